"""Wrappers: each one and all combinations, recorded ones, other messages, and bounded work on garbage."""

import gzip
import json
import sys
import tracemalloc
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from cca_core import LocalFrame, VehicleState
from cca_core.errors import InputError
from cca_core.v2x import Bsm, Tracker, decode_bsm, encode_bsm, unwrap_message
from cca_core.v2x.wrappers import split_records
from tests.support import asn1_peer as peer
from tests.support import wrapping as wrap

NESTINGS = dict(wrap.nestings())
PLAIN = Bsm(msg_count=5, id="00c0ffee", sec_mark=7.0, latitude_deg=45.0, longitude_deg=14.0, speed=0.0)
FRAME = encode_bsm(PLAIN)
RNG = np.random.default_rng(0)
LONG = peer.message(peer.random_core(RNG), [{"kind": 2, "content": RNG.bytes(400)}, peer.event_part(1 << 5)])

# first records of data/bsmTx_commsignia.gz and data/bsmTx.bin
# in github.com/usdot-jpo-ode/jpo-ode at dfb2e1624213c8ce265d7acb993427e376a46041 (Apache-2.0)
RECORDED = {
    ("ode", "wsmp", "signed", "unsecured"): (
        "001fd91f1886f86ec16c3a00000000000015d20865e00001ab0003002080a6038100400380490014465944a9ea8c588326e261"
        "0f965c6542a5361414100070000000fdfa1fa1007fff80005a0fa0007cc040ff45403ccf85fffc0fe85c0498fdffffc0fe923e"
        "98ee4ffffcfffec800400120000235da4e89d1f880afc46273f760137e80837314547c8125331d60f0067b7adf083be2dcd214"
        "3d478397ac589215a25170700831c044f79407bd914e1bd5432647442bbc0f74c3a2bd9a0efe95a69b1ad243"
    ),
    ("ode", "unsecured"): (
        "0022e12d18466c65c1493800000e00e4616183e85a8f0100c000038081bc001480b8494c4c950cd8cde6e9651116579f22a424"
        "dd78fffff00761e4fd7eb7d07f7fff80005f11d1020214c1c0ffc7c016aff4017a0ff65403b0fd204c20ffccc04f8fe40c420f"
        "fe6404cefe60e9a10133408fcfde1438103ab4138f00e1eec1048ec160103e237410445c171104e26bc103dc4154305c2c8410"
        "3b1c1c8f0a82f42103f34262d1123198103dac25fb12034ce10381c259f12038ca103574251b10e3b2210324c23ad0f23d8eff"
        "fe0000209340d10000004264bf00"
    ),
}  # fmt: skip


def frame_of(number: int, length: int = 30) -> bytes:
    """A MessageFrame of any kind, with ones as content."""
    size = bytes((length,)) if length < 128 else (length | 0x8000).to_bytes(2, "big")
    return number.to_bytes(2, "big") + size + b"\xff" * length


@pytest.mark.parametrize("nesting", NESTINGS)
def test_message_is_found_in_every_wrapper(nesting: str) -> None:
    for frame in (FRAME, LONG):
        data = NESTINGS[nesting](frame)
        found = unwrap_message(data)
        signed = "unverified" if "/signed" in nesting else None
        assert (found.data, found.name, found.message_id) == (frame, "BSM", 20)
        assert found.signed == signed
        assert decode_bsm(data) == replace(decode_bsm(frame), signed=signed)
        assert unwrap_message(bytearray(data)) == found


def test_wrappers_are_listed_from_outside() -> None:
    data = NESTINGS["hex/ethernet/wsmp-elements/signed-twice"](FRAME)
    assert unwrap_message(data).wrappers == ("hex", "ethertype", "wsmp", "signed", "signed", "unsecured")
    assert unwrap_message(wrap.rsu(FRAME)).wrappers == ("rsu",)
    assert unwrap_message(wrap.ode(FRAME)).wrappers == ("ode",)
    assert unwrap_message(FRAME).wrappers == ()


@pytest.mark.parametrize("wrappers", RECORDED, ids="-".join)
def test_recorded_wrappers(wrappers: tuple[str, ...]) -> None:
    found = unwrap_message(bytes.fromhex(RECORDED[wrappers]))
    assert found.wrappers == wrappers
    bsm = decode_bsm(RECORDED[wrappers])  # as text
    assert bsm.latitude_deg == pytest.approx(40.5, abs=0.1)
    assert bsm.longitude_deg == pytest.approx(-105.0, abs=0.1)
    assert bsm.signed == found.signed == ("unverified" if "signed" in wrappers else None)


def recorded_frames(data_dir: Path) -> list[bytes]:
    """All recorded messages, without wrappers."""
    folder = data_dir / "bsm"
    data = (folder / "j2735.MessageFrame.128.bsms.uper").read_bytes()
    frames = []
    while data:
        frames.append(unwrap_message(data).data)
        data = data[len(frames[-1]) :]
    frames += [bytes.fromhex(s["hex"]) for s in json.loads((folder / "samples.json").read_text())["samples"]]
    lines = (folder / "wyoming_rx_decoded.csv").read_text().splitlines()
    column = lines[0].split(",").index("uper_hex")
    return frames + [bytes.fromhex(line.split(",")[column]) for line in lines[1:]]


@pytest.mark.parametrize("every", [37, pytest.param(1, marks=pytest.mark.slow)])
def test_wrapped_recordings_equal_bare_ones(every: int, data_dir: Path) -> None:
    frames = recorded_frames(data_dir)
    assert len(frames) == 128 + 13 + 243
    nestings = list(NESTINGS.values())
    for i, frame in enumerate(frames):
        bare = decode_bsm(frame)
        for nesting in nestings[i % every :: every]:
            assert replace(decode_bsm(nesting(frame)), signed=None) == bare


def test_recorded_log_equals_its_table(data_dir: Path) -> None:
    records = split_records(gzip.decompress((data_dir / "bsm" / "rxMsg_BSM_and_TIM.gz").read_bytes()))
    names = [unwrap_message(payload).name for _, payload in records]
    assert (names.count("BSM"), names.count("TIM"), len(names)) == (243, 150, 393)
    found = [decode_bsm(data) for (_, data), name in zip(records, names, strict=True) if name == "BSM"]
    assert [replace(bsm, signed=None) for bsm in found] == [
        decode_bsm(frame) for frame in recorded_frames(data_dir)[141:]
    ]
    assert {bsm.signed for bsm in found} == {"unverified"}
    assert records[0][0] == 1_544_018_697.701


def test_records_are_split_with_and_without_line_feeds() -> None:
    payloads = [wrap.signed(FRAME), FRAME, wrap.wsmp(LONG)]
    for end in (b"", b"\n"):
        for header in (0, 1):  # logs of distress messages have no source
            data = b"".join(wrap.ode(payload)[header:] + end for payload in payloads)
            assert split_records(data) == [(1_544_018_697.701, payload) for payload in payloads]
            assert unwrap_message(wrap.ode(FRAME)[header:] + end).wrappers == ("ode",)
            assert split_records(data[:-3]) == []
    assert split_records(b"\xff" * 1000) == []


@pytest.mark.parametrize("source", [0, 3])
@pytest.mark.parametrize("low", [0x0014, 0x0214, 0x8014, 0x0080, 0x2880, 0x0081, 0x4000, 0x0020])
def test_record_is_no_message_by_its_latitude(source: int, low: int) -> None:
    """The first bytes of a record may look like another message or wrapper."""
    data = wrap.ode(wrap.signed(FRAME), source, latitude=(410_000_000 & ~0xFFFF) | low)
    assert unwrap_message(data).wrappers == ("ode", "signed", "unsecured")


@pytest.mark.parametrize(
    ("number", "name"),
    [(18, "MAP"), (19, "SPaT"), (29, "SRM"), (30, "SSM"), (31, "TIM"), (32, "PSM"), (41, "SDSM"),
     (245, "test message 245")],
)  # fmt: skip
def test_other_messages_are_named(number: int, name: str) -> None:
    frame = frame_of(number)
    tracker = Tracker(LocalFrame(45.0, 14.0))
    for data in (frame, wrap.wsmp(wrap.signed(frame)), frame.hex(), wrap.rsu(frame), wrap.ode(frame)):
        assert unwrap_message(data).name == name
        with pytest.raises(
            InputError, match=rf"data must hold a Basic Safety Message, was {name} \(id {number}\)"
        ):
            decode_bsm(data)
        result = tracker.update(data, 7.0)
        assert (result.kind, result.message, result.accepted) == ("other_message", name, False)
    assert tracker.counts == {"other_message": 5}
    assert tracker.dropped == ()


def test_tracker_accepts_wrapped_messages() -> None:
    tracker = Tracker(LocalFrame(45.0, 14.0))
    for i, nesting in enumerate(NESTINGS.values()):
        bsm = replace(PLAIN, msg_count=i % 128, sec_mark=round(0.1 * (i % 600), 1))
        result = tracker.update(nesting(encode_bsm(bsm)), 0.1 * i + 0.01)
        assert result.accepted
        assert result.message == "BSM"
    assert result.signed == "unverified"
    assert len(tracker.vehicles(0.1 * i)) == 1


@pytest.mark.parametrize(
    ("data", "error"),
    [
        (b"", "data must hold a frame, had 0 bytes"),
        (wrap.secured(encrypted={"recipients": b"abc", "ciphertext": bytes(60)}), "was encrypted data"),
        (wrap.secured(request=FRAME), "was a certificate request"),
        (b"\x03\x85" + bytes(40), "was data of kind 85"),
        (wrap.signed(None, payload={"digest": ("sha256", bytes(32))}), "had a hash of it in signed data"),
        (b"\x03\x81\x00\x40" * 5 + wrap.unsecured(FRAME), "began with 03810040"),
        (b"\x03\x02\x20\x28" + FRAME, "had TPID 2"),
        (b"\x13\x00\x20\x28" + FRAME, "began with 13002028"),
        (b"\x02\x20\x80\x00\x28" + FRAME, "began with 02208000"),
        (b"\x0b\x80\x41" + bytes(600), "at most 32 information elements, announced 65"),
        (b"\x0b\x01\x04\x20\x00", "ended 31 bytes too early"),
        (b"\x03\x80\x29" + FRAME, "must hold 41 bytes of content, had 40"),
        (b"\x03\x80\x27" + FRAME, "must hold 37 bytes of message, had 36"),
        (b"\x03\x80\xff" + FRAME, "ended 87 bytes too early"),
        (frame_of(99), "began with 0063"),
        (frame_of(20 + 256), "began with 0114"),
        ("0014", "must hold a frame, had 2 bytes"),
        ("001", "must be hexadecimal digits"),
        ("übel", "must be hexadecimal digits"),
        (b"Type=BSM\nPSID=0x20\n", "have a line Payload="),
        (b"Payload=zz", "must be hexadecimal digits"),
        (b"Payload=\n", "must hold a frame, had 0 bytes"),
        ("0" * 65537, "at most 65536 characters, had 65537"),
        (b"0" * 65537, "began with 30303030"),
    ],
)
def test_unusable_data_is_named(data: bytes | str, error: str) -> None:
    with pytest.raises(InputError, match=error):
        decode_bsm(data)
    assert Tracker(LocalFrame(45.0, 14.0)).update(data, 7.0).kind == "unreadable"


@pytest.mark.parametrize(
    "data",
    [
        FRAME + b"\0" * 20,
        b"\x80" + FRAME[1:],  # announces additions
        wrap.unsecured(FRAME + b"abc") + b"def",
        wrap.ethernet(wrap.wsmp(FRAME)) + b"\0" * 20,
        b"\x03\x00\x00\x20\x28" + FRAME,  # PSID with a zero before it
        b"\x03\x00\x20\x81\x85" + wrap.signed(FRAME) + bytes(133 - len(wrap.signed(FRAME))),
        wrap.signed(FRAME, hash="sha384"),
        wrap.signed(FRAME, payload={"digest": ("sha256", bytes(32))}),
        wrap.signed(FRAME, signer=("self", None)),
        f"  0x{FRAME.hex(' ')}\r\n",
        "\n".join((FRAME.hex()[:40], FRAME.hex()[40:])),
        f"type = BSM\npsid = 0x20\npayload = {FRAME.hex()}\nencryption = False",
        f"Payload=0x{wrap.signed(FRAME).hex()}",
    ],
)
def test_deviations_that_units_have(data: bytes | str) -> None:
    assert unwrap_message(data).data[2:] == FRAME[2:]
    assert decode_bsm(data).id == "00c0ffee"


def test_longest_message() -> None:
    frame = frame_of(31, 16383)
    for nesting in (wrap.unsecured, wrap.signed, wrap.rsu, lambda data: data.hex().encode()):
        assert unwrap_message(nesting(frame)).data == frame
    assert unwrap_message(wrap.wsmp(frame_of(31, 16379))).name == "TIM"


@pytest.mark.parametrize("data", [None, 20, [0, 20, 0], memoryview(FRAME), 3.0, {}])
def test_other_types_raise(data: object) -> None:
    with pytest.raises(InputError, match="data must be bytes or text, was"):
        unwrap_message(data)  # type: ignore[arg-type]


@pytest.mark.parametrize("nesting", list(NESTINGS)[::11])
def test_truncated_data_never_changes_the_message(nesting: str) -> None:
    data = NESTINGS[nesting](FRAME)
    for end in range(len(data)):
        try:
            found = unwrap_message(data[:end])
        except InputError:
            continue
        assert found.data == FRAME


# --- bounded work ---------------------------------------------------------------------------------


def garbage(seed: int, count: int) -> Iterator[bytes]:
    """Wrapped messages with flipped bits, cuts, insertions, and other content; and wrapped garbage."""
    rng = np.random.default_rng(seed)
    frames = [FRAME, LONG, frame_of(31, 200), encode_bsm(replace(PLAIN, events=frozenset({"jackknife"})))]
    frames += [
        encode_bsm(
            replace(
                PLAIN,
                id=f"{i:08x}",
                latitude_deg=45.0 + 1e-4 * i,
                speed=float(i),
                psi=0.1 * i,
                a_x=1.0 - i,
                sec_mark=7.0 if i % 2 else None,
            )
        )
        for i in range(16)
    ]
    whole = [nesting(frames[i]) for nesting in NESTINGS.values() for i in rng.integers(20, size=4)]
    nestings = list(NESTINGS.values())
    for i in range(count):
        data, other = whole[rng.integers(len(whole))], whole[rng.integers(len(whole))]
        cut = int(rng.integers(len(data) + 1))
        match i % 8:
            case 0:
                yield rng.bytes(int(rng.integers(300)))
            case 1:
                yield data[:cut]
            case 2 | 3:
                flipped = bytearray(data)
                for bit in rng.integers(8 * min(len(data), 80), size=rng.integers(1, 4)):
                    flipped[bit // 8] ^= 1 << bit % 8
                yield bytes(flipped)
            case 4:
                yield data[:cut] + other[cut:]
            case 5:
                yield data[:cut] + rng.bytes(int(rng.integers(1, 5))) + data[cut:]
            case 6 if i % 16 == 6:
                yield nestings[rng.integers(len(nestings))](rng.bytes(int(rng.integers(100))))
            case 6:
                yield data[: min(cut, 12)] + rng.bytes(int(rng.integers(200)))
            case _:
                yield data


def survived(tracker: Tracker, data: bytes, t: float) -> bool:
    """Whether data decode; nothing but InputError is raised, and the tracker takes everything."""
    result = tracker.update(data, t)
    try:
        decode_bsm(data)
    except InputError:
        assert result.kind in ("unreadable", "other_message")
        return False
    assert result.kind not in ("unreadable", "other_message")
    return True


@pytest.mark.parametrize("count", [6_000, pytest.param(1_000_000, marks=pytest.mark.slow)])
def test_wrapped_garbage_raises_input_error_only(count: int) -> None:
    tracker = Tracker(LocalFrame(45.0, 14.0))
    usable, tracked = 0, 0
    for i, data in enumerate(garbage(3, count)):
        usable += survived(tracker, data, 0.002 * i)
        if i % 50 == 0:
            tracked = max(
                tracked, len(tracker.vehicles(0.002 * i, VehicleState(x=0.0, y=0.0, psi=0.0, v_x=20.0)))
            )
            assert 0 <= tracker.health(0.002 * i).received <= 600
    assert 0.15 * count < usable < 0.7 * count  # neither all garbage nor all whole
    assert 16 <= tracked <= tracker.settings.max_tracks
    assert sum(tracker.counts.values()) == count


def calls(data: bytes | str) -> int:
    """Number of Python and C calls that unwrapping makes."""
    count = 0

    def profile(frame: object, event: str, arg: object) -> None:
        nonlocal count
        count += event.endswith("call")

    sys.setprofile(profile)
    try:
        unwrap_message(data)
    except InputError:
        pass
    finally:
        sys.setprofile(None)
    return count


@pytest.mark.parametrize("size", [10_000, 10_000_000])
def test_work_does_not_grow_with_data(size: int) -> None:
    heads = [
        b"\x03\x81\x00\x40", b"\x0b\x40" + b"\xff\0" * 64, b"\x0b\xbf\xff", b"\x03\x01\x20\x40", b"\x88\xdc",
        b"\xaa\xaa\x03\0\0\0\x88\xdc", b"\x02" * 30, b"\0\x14\x28", b"\x80\x14\xbf\xff", b"\x03\x80\x84\x7f",
        b"Payload=", b"\n", b"=", b"0x", b" ",
    ]  # fmt: skip
    for head in heads:
        data = head * (size // len(head))
        tracemalloc.start()
        try:
            assert calls(data) < 400 + (len(data) if len(data) <= 65536 else 0)
            peak = tracemalloc.get_traced_memory()[1]
        finally:
            tracemalloc.stop()
        assert peak < 2_000_000  # text of at most 64 kB in lines


def test_garbage_leaves_no_memory() -> None:
    tracker = Tracker(LocalFrame(45.0, 14.0))
    frames = list(garbage(4, 2_000))
    for i, data in enumerate(frames):
        survived(tracker, data, 0.01 * i)
    tracemalloc.start()
    try:
        before = tracemalloc.get_traced_memory()[0]
        for data in frames:
            try:
                unwrap_message(data)
            except InputError:
                pass
        assert tracemalloc.get_traced_memory()[0] - before < 10_000
    finally:
        tracemalloc.stop()
