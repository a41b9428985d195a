"""A planner without gains for its vehicle says so once, with the line to type."""

import re
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
import pytest

from cca_core import Planner, PreviewController, VehicleParams, design_gains
from cca_core.follow import StabilityRegion
from tests.support.planner_drives import straight

ROAD = straight(500.0)
VAN = VehicleParams(m=2500, I_z=5500, l_f=1.6, l_r=1.9, C_f=90000, C_r=110000, length=5.9, width=2.0)
WORDS = "^no steering gains were designed for this vehicle"


def test_vehicle_without_gains_is_warned_of_once() -> None:
    with pytest.warns(UserWarning, match=WORDS) as caught:
        Planner(VAN, ROAD, cruise_speed=10.0)
    Planner(replace(VAN, mu=0.5, length=5.0), ROAD, cruise_speed=10.0)  # warnings are errors here
    assert [each.filename for each in caught] == [__file__]
    with pytest.warns(UserWarning, match=WORDS):
        Planner(replace(VAN, m=np.array(2600.0)), ROAD, cruise_speed=10.0)  # type: ignore[arg-type]


def test_line_of_warning_silences_it() -> None:
    other = replace(VAN, m=2400.0)
    with pytest.warns(UserWarning, match=WORDS) as caught:
        Planner(other, ROAD, cruise_speed=10.0)
    typed = re.search(r"pass controller=(.*)$", str(caught[0].message))
    assert typed is not None
    vehicle = replace(VAN, m=2300.0)
    design = partial(design_gains, region=StabilityRegion(decay=0.4, damping=0.2))
    names: dict[str, Any] = {"vehicle": vehicle, "PreviewController": PreviewController}
    controller = eval(typed[1], names | {"design_gains": design})
    Planner(vehicle, ROAD, cruise_speed=10.0, controller=controller)


def test_presets_are_not_warned_of() -> None:
    for preset in (VehicleParams.bmw_320i(), VehicleParams.ford_escort(), VehicleParams.vw_vanagon()):
        Planner(replace(preset, width=1.9, mu=0.5), ROAD, cruise_speed=10.0)
