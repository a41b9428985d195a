"""The commands and files of docs/command_line.md work."""

import re
import shlex
from pathlib import Path

import numpy as np
import pytest

from cca_core import LocalFrame
from cca_core.cli import main
from cca_core.v2x import Bsm, encode_bsm

PAGE = Path(__file__).resolve().parents[2] / "docs" / "command_line.md"
BLOCK = re.compile(r"^```(console|toml)\n(.*?)^```", re.MULTILINE | re.DOTALL)


def write_inputs(folder: Path) -> None:
    """Write the route and the log that the page takes for granted."""
    s = np.linspace(0.0, 1500.0, 76)
    xy = np.column_stack((s, 200.0 - np.sqrt(1000.0**2 - (s - 750.0) ** 2) + 500.0))
    lat, lon = LocalFrame(45.0, 14.0).to_geodetic(xy)
    points = "".join(f'<trkpt lat="{a}" lon="{b}"/>' for a, b in zip(lat.tolist(), lon.tolist(), strict=True))
    (folder / "route.gpx").write_text(f"<gpx><trk><trkseg>{points}</trkseg></trk></gpx>", encoding="utf-8")
    bsm = Bsm(msg_count=1, id="00c0ffee", sec_mark=3.0, latitude_deg=45.0, longitude_deg=14.0, speed=9.0)
    (folder / "log.hex").write_text(encode_bsm(bsm).hex())


@pytest.mark.requires("matplotlib")
def test_page_runs_from_top_to_bottom(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    write_inputs(tmp_path)
    monkeypatch.chdir(tmp_path)
    ran = []
    for kind, text in BLOCK.findall(PAGE.read_text(encoding="utf-8")):
        if kind == "toml":
            name = re.match(r"# (\S+\.toml)", text)
            assert name is not None, f"the first line of a file must be its name: {text[:60]}"
            (tmp_path / name[1]).write_text(text, encoding="utf-8")
            continue
        for line in re.findall(r"^\$ cca (.*?)(?: +#.*)?$", text, re.MULTILINE):
            words, _, target = line.partition(" > ")
            code, output = main(shlex.split(words)), capsys.readouterr()
            assert code == 0, f"{line}: {output.err}"
            if target:
                (tmp_path / target).write_text(output.out, encoding="utf-8")
            ran.append(line.split()[0])
    assert set(ran) >= {"demo", "fit", "decode", "drive", "study", "report"}
    assert (tmp_path / "report.html").is_file()
