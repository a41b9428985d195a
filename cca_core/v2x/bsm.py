"""Basic Safety Messages of SAE J2735: bytes to SI units and the axes of ISO 8855, and back."""

import math
import operator
import re
from collections.abc import Mapping, Set
from typing import Any, TypeVar

from cca_core.errors import InputError
from cca_core.v2x.events import decode_events, encode_events
from cca_core.v2x.message import BrakeStatus, Bsm, PositionalAccuracy
from cca_core.v2x.uper import BitFields, close_frame, open_frame

__all__ = ["BrakeStatus", "Bsm", "PositionalAccuracy", "decode_bsm", "encode_bsm"]

_MESSAGE_ID = 20
_TRANSMISSION = ("neutral", "park", "forward", "reverse", None, None, None, None)
_SYSTEM = (None, "off", "on", "engaged")
_BOOST = (None, "off", "on")
_AUX = (None, "off", "on", None)
_TRANSMISSION_CODE = {"neutral": 0, "park": 1, "forward": 2, "reverse": 3, None: 7}
_SYSTEM_CODE = {name: code for code, name in enumerate(_SYSTEM)}
_BOOST_CODE = {name: code for code, name in enumerate(_BOOST)}
_WHEELS = tuple(None if i & 16 else tuple(bool(i & bit) for bit in (8, 4, 2, 1)) for i in range(32))
_WHEELS_CODE = {wheels: code for code, wheels in enumerate(_WHEELS[:17])}

# message count, id, second mark, latitude, longitude, elevation; accuracy: semi-major, semi-minor,
# orientation; transmission, speed, heading, steering; acceleration: long, lat, vertical; yaw rate;
# brakes: wheels, traction, ABS, stability, boost, auxiliary; width, length
_CORE = BitFields(
    (7, 32, 16, 31, 32, 16, 8, 8, 16, 3, 13, 15, 8, 12, 12, 8, 16, 5, 2, 2, 2, 2, 2, 10, 12)
)  # fmt: skip
_CORE_BYTES = 37  # three leading flags and 290 bits
_HEADING = math.pi / 14400.0  # [rad]
_ORIENTATION = math.pi / 32767.5
_STEERING = math.radians(1.5)
_YAW = math.radians(0.01)
_VERTICAL = 0.02 * 9.80665  # [m/s^2]
_Choice = TypeVar("_Choice", str, tuple[bool, ...])
_ID = re.compile("[0-9a-f]{8}")


def _heading_from_code(code: int) -> float:
    """Direction counter-clockwise from east [rad], in [-pi, pi), of a code clockwise from north."""
    return (16383.75 - code if code <= 49151 else 81918.75 - code) * _ORIENTATION


def decode_bsm(data: bytes | bytearray) -> Bsm:
    """Decode a Basic Safety Message.

    Parameters
    ----------
    data : bytes or bytearray
        A MessageFrame in unaligned packed encoding. Bytes after its end are ignored.

    Returns
    -------
    bsm : Bsm
        Part I and the event flags; other content and regional extensions are skipped. A code that the format
        reserves for later is read as unavailable.

    Raises
    ------
    InputError
        If `data` is no such message, is cut off or has a value outside its range.

    Examples
    --------
    >>> sent = Bsm(msg_count=5, id="00c0ffee", speed=13.9, events=frozenset({"hard_braking"}))
    >>> decode_bsm(encode_bsm(sent)).speed
    13.9
    """
    body = open_frame(data, _MESSAGE_ID)
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
        psi=turn * _HEADING if heading < 28800 else None,
        steering_wheel_angle=(126 - steering) * _STEERING if steering < 253 else None,
        a_x=(a_long - 2000) / 100.0 if a_long < 4001 else None,
        a_y=(2000 - a_lat) / 100.0 if a_lat < 4001 else None,
        a_z=(127 - a_vert) * _VERTICAL if a_vert else None,
        r=(32767 - yaw) * _YAW,
        accuracy=PositionalAccuracy(
            semi_major=major / 20.0 if major < 255 else None,
            semi_minor=minor / 20.0 if minor < 255 else None,
            orientation=_heading_from_code(orientation) if orientation < 65535 else None,
        ),
        transmission=_TRANSMISSION[transmission],
        brakes=BrakeStatus(
            wheels=_WHEELS[wheels],
            traction=_SYSTEM[traction],
            abs=_SYSTEM[lock],
            scs=_SYSTEM[stability],
            boost=_BOOST[boost],
            aux=_AUX[aux],
        ),
        width=width / 100.0 if width else None,
        length=length / 100.0 if length else None,
        events=events,
    )


def encode_bsm(bsm: Bsm) -> bytes:
    """Encode a Basic Safety Message; each value is rounded to the nearest that the format has.

    Parameters
    ----------
    bsm : Bsm
        What to send. Angles may be any number of turns away.

    Returns
    -------
    data : bytes
        A MessageFrame in unaligned packed encoding: 40 bytes, 45 or 46 with event flags.

    Raises
    ------
    InputError
        If a value is outside its range or not of its kind.
    """
    _check_kinds(bsm)
    ellipse, brakes = bsm.accuracy, bsm.brakes
    east = _number("longitude_deg", bsm.longitude_deg, 1e7, -1_800_000_000, 1_800_000_000, 1_800_000_001)
    codes = (
        _count(bsm.msg_count),
        int(bsm.id, 16),
        _number("sec_mark", bsm.sec_mark, 1000.0, 0, 60999, 65535),
        _number("latitude_deg", bsm.latitude_deg, 1e7, -900_000_000, 900_000_000, 900_000_001) + 900_000_000,
        (east if east != -1_800_000_000 else 1_800_000_000) + 1_799_999_999,
        _number("elevation", bsm.elevation, 10.0, -4095, 61439, -4096) + 4096,
        _number("semi_major", ellipse.semi_major, 20.0, 0, 254, 255),
        _number("semi_minor", ellipse.semi_minor, 20.0, 0, 254, 255),
        _direction("orientation", ellipse.orientation, 65535),
        _choice("transmission", bsm.transmission, _TRANSMISSION_CODE),
        _number("speed", bsm.speed, 50.0, 0, 8190, 8191),
        _direction("psi", bsm.psi, 28800),
        126 - _number("steering_wheel_angle", bsm.steering_wheel_angle, 1.0 / _STEERING, -126, 126, -127),
        _number("a_x", bsm.a_x, 100.0, -2000, 2000, 2001) + 2000,
        2000 - _number("a_y", bsm.a_y, 100.0, -2000, 2000, -2001),
        127 - _number("a_z", bsm.a_z, 1.0 / _VERTICAL, -127, 126, 127),
        32767 - _number("r", bsm.r, 1.0 / _YAW, -32767, 32767, 0),
        _choice("wheels", brakes.wheels, _WHEELS_CODE),
        _choice("traction", brakes.traction, _SYSTEM_CODE),
        _choice("abs", brakes.abs, _SYSTEM_CODE),
        _choice("scs", brakes.scs, _SYSTEM_CODE),
        _choice("boost", brakes.boost, _BOOST_CODE),
        _choice("aux", brakes.aux, _BOOST_CODE),
        _number("width", bsm.width, 100.0, 1, 1023, 0),
        _number("length", bsm.length, 100.0, 1, 4095, 0),
    )
    bits, n_bits = _CORE.pack(codes), 3 + _CORE.n_bits
    if bsm.events:
        part, width = encode_events(bsm.events)
        bits, n_bits = (1 << n_bits - 2 | bits) << width | part, n_bits + width
    return close_frame(bits, n_bits, _MESSAGE_ID)


def _check_kinds(bsm: Any) -> None:
    if not isinstance(bsm, Bsm):
        raise InputError(f"bsm must be a Bsm, was {bsm!r}")
    parts: tuple[Any, ...] = (bsm.accuracy, bsm.brakes)
    if not (isinstance(parts[0], PositionalAccuracy) and isinstance(parts[1], BrakeStatus)):
        raise InputError(f"accuracy and brakes must be Accuracy and Brakes, were {parts!r}")
    name: Any = bsm.id
    if not isinstance(name, str) or not _ID.fullmatch(name):
        raise InputError(f"id must be 8 hexadecimal digits in lower case, was {name!r}")
    events: Any = bsm.events
    if not isinstance(events, Set):
        raise InputError(f"events must be a set of names, was {events!r}")


def _number(name: str, value: float | None, scale: float, least: int, most: int, absent: int) -> int:
    if value is None:
        return absent
    try:
        code = round(value * scale)
    except (TypeError, ValueError, OverflowError):
        raise InputError(f"{name} must be a finite number or None, was {value!r}") from None
    if not least <= code <= most:
        raise InputError(f"{name} must be {least / scale:.8g} to {most / scale:.8g}, was {value!r}")
    return code


def _direction(name: str, value: float | None, steps: int) -> int:
    """Code clockwise from north, of so many steps a turn, of a direction counter-clockwise from east."""
    if value is None:
        return steps
    try:
        return round((0.25 - value / math.tau) % 1.0 * steps) % steps
    except (TypeError, ValueError, OverflowError):
        raise InputError(f"{name} must be a finite angle or None, was {value!r}") from None


def _choice(name: str, value: _Choice | None, codes: Mapping[_Choice | None, int]) -> int:
    try:
        return codes[value]
    except (KeyError, TypeError):
        allowed = ", ".join(map(repr, codes)) if len(codes) < 9 else "four bools or None"
        raise InputError(f"{name} must be one of {allowed}; was {value!r}") from None


def _count(value: int) -> int:
    try:
        count = operator.index(value)
    except TypeError:
        count = -1
    if not 0 <= count <= 127:
        raise InputError(f"msg_count must be an integer from 0 to 127, was {value!r}")
    return count
