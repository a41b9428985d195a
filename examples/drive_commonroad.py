"""Drive a CommonRoad scenario through its recorded traffic: ``python drive_commonroad.py FILE.xml``."""

import sys
import tempfile
from pathlib import Path

from cca_core.adapters import read_commonroad_map
from cca_core.sim import drive_commonroad

POINT = "<point><x>{}</x><y>{}</y></point>"
STATE = (
    "<{tag}><position><point><x>{x}</x><y>0</y></point></position><orientation><exact>0</exact></orientation>"
    "<time><exact>{step}</exact></time><velocity><exact>{v}</exact></velocity></{tag}>"
)
CAR = "".join(STATE.format(tag="state", x=50 + k, step=k, v=10) for k in range(1, 121))
SAMPLE = f"""<commonRoad commonRoadVersion="2020a" timeStepSize="0.1" benchmarkID="ZAM_Sample-1">
<lanelet id="1"><leftBound>{POINT.format(0, 1.75)}{POINT.format(300, 1.75)}</leftBound>
<rightBound>{POINT.format(0, -1.75)}{POINT.format(300, -1.75)}</rightBound></lanelet>
<dynamicObstacle id="2"><type>car</type>
<shape><rectangle><length>4.5</length><width>1.8</width></rectangle></shape>
{STATE.format(tag="initialState", x=50, step=0, v=10)}<trajectory>{CAR}</trajectory></dynamicObstacle>
<planningProblem id="3">{STATE.format(tag="initialState", x=10, step=0, v=15)}<goalState>
<position><rectangle><length>20</length><width>3.5</width><center><x>130</x><y>0</y></center></rectangle>
</position><time><intervalStart>90</intervalStart><intervalEnd>120</intervalEnd></time>
</goalState></planningProblem></commonRoad>"""

with tempfile.TemporaryDirectory() as folder:
    sample = Path(folder) / "sample.xml"
    sample.write_text(SAMPLE, encoding="utf-8")
    scenario = read_commonroad_map(sys.argv[1] if len(sys.argv) > 1 else sample)
for key, value in drive_commonroad(scenario).summary().items():
    print(f"{key:18} {value}")
