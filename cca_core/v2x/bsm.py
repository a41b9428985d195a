"""Basic Safety Messages of SAE J2735: bytes to SI units and ISO 8855 axes, and back."""

import math
import re
from collections.abc import Mapping, Set
from typing import Any, NamedTuple

from cca_core._checks import shown
from cca_core.errors import InputError
from cca_core.v2x._plain import read_count, read_number
from cca_core.v2x.events import decode_events, encode_events
from cca_core.v2x.message import BrakeStatus, Bsm, PositionalAccuracy
from cca_core.v2x.uper import BitFields, close_frame, open_frame
from cca_core.v2x.wrappers import MessageFrame, unwrap_message

__all__ = ["BrakeStatus", "Bsm", "PositionalAccuracy", "decode_bsm", "encode_bsm"]


class _Codes(NamedTuple):
    """Values of the codes of a field, and the code of each value."""

    values: tuple[Any, ...]
    of: Mapping[Any, int]


def _codes(*values: Any, unavailable: int) -> _Codes:
    """Return a table of codes; None is encoded as `unavailable`."""
    return _Codes(values, {value: code for code, value in enumerate(values)} | {None: unavailable})


_MESSAGE_ID = 20
_CODES = {
    "transmission": _codes("neutral", "park", "forward", "reverse", None, None, None, None, unavailable=7),
    "wheels": _codes(
        *(None if i & 16 else tuple(bool(i & bit) for bit in (8, 4, 2, 1)) for i in range(32)), unavailable=16
    ),
    "system": _codes(None, "off", "on", "engaged", unavailable=0),
    "boost": _codes(None, "off", "on", unavailable=0),
    "aux": _codes(None, "off", "on", None, unavailable=0),
}
_UNIT = {  # SI value of a step of the code
    "psi": math.pi / 14400.0,
    "orientation": math.pi / 32767.5,
    "steering_wheel_angle": math.radians(1.5),
    "r": math.radians(0.01),
    "a_z": 0.02 * 9.80665,
}
# message count, id, second mark, latitude, longitude, elevation; accuracy: semi-major, semi-minor,
# orientation; transmission, speed, heading, steering; acceleration: long, lat, vertical; yaw rate;
# brakes: wheels, traction, ABS, stability, boost, auxiliary; width, length
_CORE = BitFields(
    (7, 32, 16, 31, 32, 16, 8, 8, 16, 3, 13, 15, 8, 12, 12, 8, 16, 5, 2, 2, 2, 2, 2, 10, 12)
)  # fmt: skip
_CORE_BYTES = 37  # three leading flags and 290 bits


def _heading_from_code(code: int) -> float:
    """Return the direction [rad], counter-clockwise from east, of a code clockwise from north."""
    return (16383.75 - code if code <= 49151 else 81918.75 - code) * _UNIT["orientation"]


def decode_bsm(data: bytes | bytearray | str) -> Bsm:
    """Decode a Basic Safety Message.

    Parameters
    ----------
    data : bytes, bytearray or str
        A MessageFrame in unaligned packed encoding, bare or in the wrappers that `unwrap_message` removes.
        Bytes after its end are ignored.

    Returns
    -------
    bsm : Bsm
        Part I and the event flags; other content and regional extensions are skipped. Reserved codes are
        decoded as unavailable. Signatures are not verified: see `Bsm.signed`.

    Raises
    ------
    InputError
        If `data` is not such a message, is incomplete or has a value outside its range. Another message is
        named.

    Examples
    --------
    >>> sent = Bsm(msg_count=5, id="00c0ffee", speed=13.9, events=frozenset({"hard_braking"}))
    >>> decode_bsm(encode_bsm(sent)).speed
    13.9
    """
    frame = unwrap_message(data)
    if frame.message_id != _MESSAGE_ID:
        raise InputError(f"data must hold a Basic Safety Message, was {frame.name} (id {frame.message_id})")
    return decode_frame(frame)


def decode_frame(frame: MessageFrame) -> Bsm:
    """Decode a Basic Safety Message without wrappers."""
    body = open_frame(frame.data, _MESSAGE_ID)
    if len(body) < _CORE_BYTES:
        raise InputError(f"data must hold at least {_CORE_BYTES} bytes of message, had {len(body)}")
    (
        count, name, mark, lat, lon, elevation, major, minor, orientation, transmission, speed, heading,
        steering, a_long, a_lat, a_vert, yaw, wheels, traction, lock, stability, boost, aux, width, length,
    ) = _CORE.unpack(int.from_bytes(body[:_CORE_BYTES], "big") >> 3)  # fmt: skip
    if (
        lat > 1_800_000_001 or lon > 3_600_000_000 or heading > 28800 or steering > 253 or a_long > 4001
        or a_lat > 4001 or a_vert > 254 or yaw > 65534 or boost > 2
    ):  # fmt: skip
        raise InputError(f"data must have values within their ranges, Part I was {body[:_CORE_BYTES].hex()}")
    system = _CODES["system"].values
    turn = 7200 - heading if heading <= 21600 else 36000 - heading
    events: frozenset[str] = frozenset()
    if body[0] & 0x40:
        events = decode_events(int.from_bytes(body, "big"), 8 * len(body) - 3 - _CORE.n_bits)
    return Bsm(
        msg_count=count,
        id=f"{name:08x}",
        sec_mark=mark / 1000.0 if mark < 61000 else None,
        latitude_deg=(lat - 900_000_000) / 1e7 if lat <= 1_800_000_000 else None,
        longitude_deg=(lon - 1_799_999_999) / 1e7 if lon < 3_600_000_000 else None,
        elevation=(elevation - 4096) / 10.0 if elevation else None,
        speed=speed / 50.0 if speed < 8191 else None,
        psi=turn * _UNIT["psi"] if heading < 28800 else None,
        steering_wheel_angle=(126 - steering) * _UNIT["steering_wheel_angle"] if steering < 253 else None,
        a_x=(a_long - 2000) / 100.0 if a_long < 4001 else None,
        a_y=(2000 - a_lat) / 100.0 if a_lat < 4001 else None,
        a_z=(127 - a_vert) * _UNIT["a_z"] if a_vert else None,
        r=(32767 - yaw) * _UNIT["r"],
        accuracy=PositionalAccuracy(
            semi_major=major / 20.0 if major < 255 else None,
            semi_minor=minor / 20.0 if minor < 255 else None,
            orientation=_heading_from_code(orientation) if orientation < 65535 else None,
        ),
        transmission=_CODES["transmission"].values[transmission],
        brakes=BrakeStatus(
            wheels=_CODES["wheels"].values[wheels],
            traction=system[traction],
            abs=system[lock],
            scs=system[stability],
            boost=_CODES["boost"].values[boost],
            aux=_CODES["aux"].values[aux],
        ),
        width=width / 100.0 if width else None,
        length=length / 100.0 if length else None,
        events=events,
        signed=frame.signed,
    )


def encode_bsm(bsm: Bsm) -> bytes:
    """Encode a Basic Safety Message; each value is rounded to the nearest code.

    Parameters
    ----------
    bsm : Bsm
        Message; angles may be any number of turns off. `Bsm.signed` is not encoded.

    Returns
    -------
    data : bytes
        A MessageFrame in unaligned packed encoding: 40 bytes, 45 or 46 with event flags.

    Raises
    ------
    InputError
        If a value is outside its range or of another type.
    """
    _check_kinds(bsm)
    ellipse, brakes = bsm.accuracy, bsm.brakes
    east = _number("longitude_deg", bsm.longitude_deg, 1e7, -1_800_000_000, 1_800_000_000, 1_800_000_001)
    codes = (
        read_count(bsm.msg_count),
        int(bsm.id, 16),
        _number("sec_mark", bsm.sec_mark, 1000.0, 0, 60999, 65535),
        _number("latitude_deg", bsm.latitude_deg, 1e7, -900_000_000, 900_000_000, 900_000_001) + 900_000_000,
        (east if east != -1_800_000_000 else 1_800_000_000) + 1_799_999_999,
        _number("elevation", bsm.elevation, 10.0, -4095, 61439, -4096) + 4096,
        _number("semi_major", ellipse.semi_major, 20.0, 0, 254, 255),
        _number("semi_minor", ellipse.semi_minor, 20.0, 0, 254, 255),
        _direction("orientation", ellipse.orientation, 65535),
        _choice("transmission", bsm.transmission),
        _number("speed", bsm.speed, 50.0, 0, 8190, 8191),
        _direction("psi", bsm.psi, 28800),
        126
        - _number(
            "steering_wheel_angle",
            bsm.steering_wheel_angle,
            1.0 / _UNIT["steering_wheel_angle"],
            -126,
            126,
            -127,
        ),
        _number("a_x", bsm.a_x, 100.0, -2000, 2000, 2001) + 2000,
        2000 - _number("a_y", bsm.a_y, 100.0, -2000, 2000, -2001),
        127 - _number("a_z", bsm.a_z, 1.0 / _UNIT["a_z"], -127, 126, 127),
        32767 - _number("r", bsm.r, 1.0 / _UNIT["r"], -32767, 32767, 0),
        _choice("wheels", brakes.wheels),
        _choice("traction", brakes.traction, "system"),
        _choice("abs", brakes.abs, "system"),
        _choice("scs", brakes.scs, "system"),
        _choice("boost", brakes.boost),
        _choice("aux", brakes.aux),
        _number("width", bsm.width, 100.0, 1, 1023, 0),
        _number("length", bsm.length, 100.0, 1, 4095, 0),
    )
    bits, n_bits = _CORE.pack(codes), 3 + _CORE.n_bits
    if bsm.events:
        part, width = encode_events(bsm.events)
        bits, n_bits = (1 << n_bits - 2 | bits) << width | part, n_bits + width
    return close_frame(bits, n_bits, _MESSAGE_ID)


def _check_kinds(bsm: Any) -> None:
    """Check the types of a message."""
    if not isinstance(bsm, Bsm):
        raise InputError(f"bsm must be a Bsm, was {shown(bsm)}")
    parts: tuple[Any, ...] = (bsm.accuracy, bsm.brakes)
    if not (isinstance(parts[0], PositionalAccuracy) and isinstance(parts[1], BrakeStatus)):
        raise InputError(
            f"accuracy and brakes must be PositionalAccuracy and BrakeStatus, were {shown(parts)}"
        )
    name: Any = bsm.id
    if not isinstance(name, str) or not re.fullmatch("[0-9a-f]{8}", name):
        raise InputError(f"id must be 8 hexadecimal digits in lower case, was {shown(name)}")
    events: Any = bsm.events
    if not isinstance(events, Set):
        raise InputError(f"events must be a set of names, was {shown(events)}")


def _number(name: str, value: float | None, scale: float, lowest: int, highest: int, unavailable: int) -> int:
    """Return the code of a number, `scale` steps a unit."""
    if value is None:
        return unavailable
    scaled = read_number(name, value) * scale
    if not math.isfinite(scaled):
        raise InputError(f"{name} must be a finite number or None, was {shown(value)}")
    code = round(scaled)
    if not lowest <= code <= highest:
        raise InputError(f"{name} must be {lowest / scale:.8g} to {highest / scale:.8g}, was {shown(value)}")
    return code


def _direction(name: str, value: float | None, steps: int) -> int:
    """Return the code clockwise from north, `steps` a turn, of a direction counter-clockwise from east."""
    if value is None:
        return steps
    angle = read_number(name, value)
    if not math.isfinite(angle):
        raise InputError(f"{name} must be a finite angle or None, was {shown(value)}")
    return round((0.25 - angle / math.tau) % 1.0 * steps) % steps


def _choice(name: str, value: Any, table: str = "") -> int:
    """Return the code of a value with a name."""
    codes = _CODES[table or name].of
    try:
        return codes[value]
    except Exception:  # a value may be of any class
        allowed = ", ".join(map(repr, codes)) if len(codes) < 9 else "four bools or None"
        raise InputError(f"{name} must be one of {allowed}; was {shown(value)}") from None
