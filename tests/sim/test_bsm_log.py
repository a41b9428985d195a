"""Recorded messages: several kinds of files, and as traffic of a run."""

import gzip
import json
from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from cca_core import LocalFrame, Road
from cca_core.errors import InputError
from cca_core.path import interpolate_path
from cca_core.sim import Scenario, read_bsm_log, simulate
from cca_core.sim.scenarios.eebl import CAR
from cca_core.v2x import Bsm, decode_bsm, encode_bsm, unwrap_message
from tests.support import wrapping as wrap

MARKS = [57.5, 57.6, 57.8, 59.9, 0.0, 0.1]


def message(mark: float, count: int = 0) -> bytes:
    return encode_bsm(
        Bsm(
            msg_count=count, id="00c0ffee", sec_mark=mark, latitude_deg=41.3, longitude_deg=-105.6,
            speed=10.0, psi=0.0, length=4.5, width=1.8,
        )
    )  # fmt: skip


def test_hexadecimal_lines(tmp_path: Path) -> None:
    file = tmp_path / "log.hex"
    file.write_text("\n".join(message(mark, i).hex() for i, mark in enumerate(MARKS)))
    frames = read_bsm_log(file, start=2.0, latency=0.1)
    assert [t for t, _ in frames] == pytest.approx([2.1, 2.2, 2.4, 4.5, 4.6, 4.7])
    for t, data in frames:
        assert decode_bsm(data).sec_mark == pytest.approx(t - 0.1, abs=1e-3)
        assert decode_bsm(data).speed == 10.0


@pytest.mark.parametrize("form", ["lines", "list", "table", "hex"])
def test_recorded_times(form: str, tmp_path: Path) -> None:
    records = [{"t": 100.0 + 0.5 * i, "hex": message(mark).hex()} for i, mark in enumerate(MARKS)]
    text = {
        "lines": "\n".join(map(json.dumps, records)), "list": json.dumps({"samples": records}),
        "table": "t,hex\n" + "\n".join(f"{r['t']},{r['hex']}" for r in records),
        "hex": "\n".join(f"{r['t']} {r['hex']}" for r in records),
    }[form]  # fmt: skip
    file = tmp_path / "log"
    file.write_text(text)
    assert [t for t, _ in read_bsm_log(file)] == pytest.approx([0.0, 0.5, 1.0, 1.5, 2.0, 2.5])


@pytest.mark.parametrize("text", ["", "xyz", "[1, 2]", '{"a": 1}', "[{]", "t,hex\nx,00"])
def test_invalid_file_raises(text: str, tmp_path: Path) -> None:
    file = tmp_path / "log"
    file.write_text(text)
    with pytest.raises(InputError, match="path"):
        read_bsm_log(file)
    with pytest.raises(InputError, match="path"):
        read_bsm_log(tmp_path / "none")


def test_immediate_forward_messages(tmp_path: Path) -> None:
    file = tmp_path / "log.txt"
    file.write_bytes(
        b"\n".join(wrap.rsu(wrap.signed(message(mark, i)), "\r\n") for i, mark in enumerate(MARKS))
    )
    frames = read_bsm_log(file, latency=0.1)
    assert [t for t, _ in frames] == pytest.approx([0.1, 0.2, 0.4, 2.5, 2.6, 2.7])
    assert [data for _, data in frames] == [unwrap_message(data).data for _, data in frames]


@pytest.mark.parametrize("compress", [bytes, gzip.compress])
def test_binary_log(compress: Callable[[bytes], bytes], tmp_path: Path) -> None:
    tim = b"\0\x1f\x02\0\0"
    file = tmp_path / "rxMsg"
    records = [wrap.ode(wrap.signed(message(mark)), seconds=50 + i) for i, mark in enumerate(MARKS[:2])]
    file.write_bytes(compress(b"".join((*records, wrap.ode(tim, seconds=53)))))
    frames = read_bsm_log(file, start=1.0)
    assert [t for t, _ in frames] == [1.0, 2.0, 4.0]
    assert [unwrap_message(data).name for _, data in frames] == ["BSM", "BSM", "TIM"]


@pytest.mark.parametrize(
    "content",
    [
        pytest.param(b"\x1f\x8b", id="mark of gzip alone"),
        pytest.param(gzip.compress(b"00", mtime=0)[:-9], id="gzip cut"),
        pytest.param(b"\xff\xfe", id="no record"),
        pytest.param(wrap.ode(b"0014")[:-1], id="record cut"),
    ],
)
def test_bad_binary_files(content: bytes, tmp_path: Path) -> None:
    file = tmp_path / "log"
    file.write_bytes(content)
    with pytest.raises(InputError, match="path must be"):
        read_bsm_log(file)


def test_recorded_binary_log_equals_its_table(data_dir: Path) -> None:
    log = read_bsm_log(data_dir / "bsm" / "rxMsg_BSM_and_TIM.gz")
    table = read_bsm_log(data_dir / "bsm" / "wyoming_rx_decoded.csv")
    assert [data for _, data in log if unwrap_message(data).name == "BSM"] == [data for _, data in table]
    assert len(log) == 243 + 150


def test_undecodable_bytes_are_passed_through(tmp_path: Path) -> None:
    file = tmp_path / "log"
    file.write_text(f"{message(1.0).hex()}\nffff\n{message(1.1).hex()}")
    assert [data for _, data in read_bsm_log(file)][1] == b"\xff\xff"


def test_recorded_messages_become_traffic(data_dir: Path) -> None:
    """The recorded car is the lead vehicle of an ego that receives, tracks and follows it."""
    frames = read_bsm_log(data_dir / "bsm" / "wyoming_rx_decoded.csv", latency=0.05)
    assert len(frames) == 243
    assert all(a <= b for (a, _), (b, _) in pairwise(frames))
    first = decode_bsm(frames[0][1])
    assert first.latitude_deg is not None
    assert first.longitude_deg is not None
    frame = LocalFrame(first.latitude_deg, first.longitude_deg)
    drive = [decode_bsm(data) for _, data in frames[:130]]
    xy = frame.to_local([b.latitude_deg for b in drive], [b.longitude_deg for b in drive])
    moved = np.concatenate(([True], np.hypot(*np.diff(xy, axis=0).T) > 0.3))
    xy = xy[moved][::6]
    behind = xy[0] - 60.0 * (xy[1] - xy[0]) / np.hypot(*(xy[1] - xy[0]))
    path = interpolate_path(np.vstack((behind, xy)))
    scenario = Scenario(
        name="recorded", case=None, road=Road(path), vehicle=CAR, start=5.0, v_x=20.0, cruise_speed=25.0,
        road_users=(), duration=6.0, origin=(first.latitude_deg, first.longitude_deg),
    )  # fmt: skip
    log = simulate(scenario, bsm_log=frames)
    due = sum(t <= log.t[-1] + 1e-9 for t, _ in frames)
    assert len(log.received) == due > 20
    assert log.time_of("first_received", first.id) < 0.2
    assert log.command.tobytes() == simulate(scenario, bsm_log=frames).command.tobytes()
    silent = simulate(replace(scenario, ego_type="sensor"), bsm_log=frames)
    assert silent.received == ()
    assert not np.array_equal(silent.command[:, 1], log.command[:, 1])  # the ego reacts to the messages
