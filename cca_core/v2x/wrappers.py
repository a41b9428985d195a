"""Wrappers that modems, roadside units and logs put around a J2735 message."""

from dataclasses import dataclass

from cca_core._repr import short_repr
from cca_core.errors import InputError
from cca_core.v2x.uper import frame_extent

__all__ = ["MessageFrame", "split_frames", "split_records", "unwrap_message"]

# DE_DSRC_MessageID of SAE J2735; 240 to 255 are for tests and local use
_NAMES = {
    18: "MAP", 19: "SPaT", 20: "BSM", 21: "CSR", 22: "EVA", 23: "ICA", 24: "NMEA", 25: "PDM", 26: "PVD",
    27: "RSA", 28: "RTCM", 29: "SRM", 30: "SSM", 31: "TIM", 32: "PSM", 33: "RSM", 34: "RWM", 35: "PDC",
    36: "PDR", 37: "TAM", 38: "TUM", 39: "TUMack", 40: "CCM", 41: "SDSM", 42: "MSCM", 43: "RGA", 44: "PSM2",
} | {number: f"test message {number}" for number in range(240, 256)}  # fmt: skip
_MAX_TEXT = 1 << 16  # characters; the longest frame has half as many hexadecimal digits
_MAX_SECURITY = 4  # signed data within signed data
# [bytes] source of the message (1), place and motion of the unit (16), time (4 + 2), result of the security
# check (1), length (2), all little-endian; logs of distress messages have no source
_RECORD_HEADERS = (26, 25)
_NOT_PLAIN = {0x82: "encrypted data", 0x83: "a certificate request", 0x84: "a certificate request"}


@dataclass(frozen=True, slots=True, kw_only=True)
class MessageFrame:
    """A J2735 message without the wrappers around it.

    Parameters
    ----------
    data : bytes
        The MessageFrame in unaligned packed encoding.
    message_id : int
        Its number (DSRCmsgID).
    name : str
        Its short name: ``"BSM"``, ``"SPaT"``, ``"MAP"``, ``"TIM"``, ``"PSM"`` and so on.
    wrappers : tuple of str
        Wrappers that were removed, the outermost first: ``"hex"``, ``"rsu"``, ``"ode"``, ``"ethertype"``,
        ``"wsmp"``, ``"signed"``, ``"unsecured"``.
    signed : str or None
        ``"unverified"`` if the message is part of signed data: the signature is not checked. None without.
    """

    data: bytes
    message_id: int
    name: str
    wrappers: tuple[str, ...] = ()
    signed: str | None = None

    __repr__ = short_repr


class _Cursor:
    """Position in bytes; nothing is copied."""

    __slots__ = ("begin", "data", "end")

    def __init__(self, data: bytes | bytearray) -> None:
        self.data, self.begin, self.end = data, 0, len(data)

    def starts_with(self, head: bytes) -> bool:
        """Return whether the next bytes are these."""
        return self.data.startswith(head, self.begin, self.end)

    def skip(self, count: int) -> None:
        """Leave out bytes."""
        self.begin += count
        if self.begin > self.end:
            raise InputError(
                f"data must hold what it announces, ended {self.begin - self.end} bytes too early"
            )

    def number(self, width: int = 1) -> int:
        """Read an unsigned number, most significant byte first."""
        begin = self.begin
        self.skip(width)
        return int.from_bytes(self.data[begin : self.begin], "big")

    def narrow(self, length: int) -> None:
        """Leave out what follows the next `length` bytes."""
        if length > self.end - self.begin:
            raise InputError(f"data must hold {length} bytes of content, had {self.end - self.begin}")
        self.end = self.begin + length


def unwrap_message(data: bytes | bytearray | str) -> MessageFrame:
    """Return the J2735 message in bytes or text as a radio, a roadside unit or a log delivers them.

    Parameters
    ----------
    data : bytes, bytearray or str
        From the outside inwards, each one optional: hexadecimal digits or the text form of immediate
        forward messages (``Payload=``); the header of an ODE log record; EtherType 88DC; WSMP version 3
        (IEEE 1609.3); unsecured or signed data (IEEE 1609.2); the MessageFrame. Bytes after its end are
        ignored.

    Returns
    -------
    frame : MessageFrame
        The message and the wrappers around it. Its content is not decoded.

    Raises
    ------
    InputError
        If there is no message, it is incomplete or encrypted, or a wrapper is of an unknown kind.

    Notes
    -----
    Signatures are not verified. Radios verify them and should drop messages that fail.

    Examples
    --------
    >>> from cca_core.v2x import Bsm, encode_bsm
    >>> frame = encode_bsm(Bsm(msg_count=5, id="00c0ffee"))
    >>> found = unwrap_message(bytes.fromhex("038028") + frame)
    >>> found.name, found.wrappers, found.data == frame
    ('BSM', ('unsecured',), True)
    """
    content, wrappers = _to_bytes(data)
    cursor = _Cursor(content)
    if not _is_frame(cursor, exactly=True):
        _take_off_headers(cursor, wrappers)
        _take_off_security(cursor, wrappers)
    head = bytes(content[cursor.begin : min(cursor.begin + 4, cursor.end)])
    if len(head) > 2 and (head[0] & 0x7F or head[1] not in _NAMES):
        raise InputError(
            f"data must hold a J2735 message, bare or in a known wrapper, began with {head.hex()}"
        )
    number, _, end = frame_extent(content, cursor.begin, cursor.end)
    return MessageFrame(
        data=bytes(content[cursor.begin : end]),
        message_id=number,
        name=_NAMES[number],
        wrappers=tuple(wrappers),
        signed="unverified" if "signed" in wrappers else None,
    )


def split_records(data: bytes) -> list[tuple[float, bytes]]:
    """Return the times [s] and the payloads of the records of a binary ODE log; empty if it is none."""
    for header in _RECORD_HEADERS:
        records, begin = [], 0
        while len(data) - begin >= header:
            end = begin + header + int.from_bytes(data[begin + header - 2 : begin + header], "little")
            seconds = int.from_bytes(data[begin + header - 9 : begin + header - 5], "little")
            thousandths = int.from_bytes(data[begin + header - 5 : begin + header - 3], "little")
            if end == begin + header or end > len(data) or thousandths > 999:
                break
            records.append((seconds + thousandths / 1000.0, data[begin + header : end]))
            begin = end + data.startswith(b"\n", end)  # some units end each record with a line feed
        if begin == len(data):
            return records
    return []


def split_frames(data: bytes) -> list[bytes]:
    """Return the frames of a file that holds nothing but bare messages; empty if it is none."""
    frames, cursor = [], _Cursor(data)
    while cursor.begin < cursor.end and _is_frame(cursor, exactly=False):
        end = frame_extent(data, cursor.begin, cursor.end)[2]
        frames.append(data[cursor.begin : end])
        cursor.begin = end
    return frames if cursor.begin == cursor.end else []


def _to_bytes(data: object) -> tuple[bytes | bytearray, list[str]]:
    """Return bytes, from text where the data is text, and the wrappers that were removed for it."""
    if isinstance(data, (bytes, bytearray)):
        if data[:1] < b"\t" or data[:1] == b"\x0b" or len(data) > _MAX_TEXT or not data.isascii():
            return data, []  # binary forms begin like this or hold a byte above 127
        text = data.decode("ascii")
    elif isinstance(data, str):
        text = data
    else:
        raise InputError(f"data must be bytes or text, was {type(data).__name__}")
    if len(text) > _MAX_TEXT:
        raise InputError(f"data must have at most {_MAX_TEXT} characters, had {len(text)}")
    wrappers = ["hex"]
    for line in text.splitlines():
        key, separator, value = line.partition("=")
        if separator and key.strip().lower() == "payload":
            text, wrappers = value, ["rsu"]
            break
    digits = text.strip()
    try:
        return bytes.fromhex(digits[2:] if digits[:2] in ("0x", "0X") else digits), wrappers
    except ValueError:
        raise InputError(
            f"data must be hexadecimal digits or have a line Payload= if it is text, was {text[:40]!r}"
        ) from None


def _is_frame(cursor: _Cursor, *, exactly: bool) -> bool:
    """Return whether a message of a known kind begins here, and, if asked, ends with the data."""
    if not cursor.starts_with(b"\0") and not cursor.starts_with(b"\x80"):
        return False
    try:
        number, _, end = frame_extent(cursor.data, cursor.begin, cursor.end)
    except InputError:
        return False
    return number in _NAMES and (end == cursor.end or not exactly)


def _take_off_headers(cursor: _Cursor, wrappers: list[str]) -> None:
    """Move past the header of a log record, an EtherType and a WSMP header."""
    size = cursor.end - cursor.data.endswith(b"\n")
    for header in _RECORD_HEADERS:
        length = int.from_bytes(cursor.data[header - 2 : header], "little")
        if header + length in (size, cursor.end) and length:
            cursor.skip(header)
            if _is_message(cursor):
                wrappers.append("ode")
                break
            cursor.begin -= header
    if _is_frame(cursor, exactly=False):
        return
    if link := _link_header(cursor):
        cursor.skip(link)
        wrappers.append("ethertype")
    if _is_wsmp(cursor):
        _take_off_wsmp(cursor)
        wrappers.append("wsmp")


def _is_message(cursor: _Cursor) -> bool:
    """Return whether a message, bare or in a wrapper of the air interface, begins here."""
    wrapped = _link_header(cursor) or _is_wsmp(cursor) or _is_security(cursor)
    return bool(wrapped) or _is_frame(cursor, exactly=False)


def _link_header(cursor: _Cursor) -> int:
    """Return the length of a header of the data link that ends with the EtherType of WSMP; 0 without."""
    for before, head in ((0, b""), (6, b"\xaa\xaa\x03\0\0\0"), (12, b"")):  # bare, LLC and SNAP, Ethernet
        at = cursor.begin + before
        if cursor.starts_with(head) and cursor.data.startswith(b"\x88\xdc", at, cursor.end):
            return before + 2
    return 0


def _is_wsmp(cursor: _Cursor) -> bool:
    """Return whether a WSMP packet begins here: version 3, subtype 0, then elements or a TPID."""
    return cursor.starts_with(b"\x0b") or (cursor.starts_with(b"\3") and not _is_security(cursor))


def _is_security(cursor: _Cursor) -> bool:
    """Return whether data of IEEE 1609.2 begins here: version 3, then a tag."""
    return cursor.starts_with(b"\3") and cursor.data[cursor.begin + 1 : cursor.begin + 2] >= b"\x80"


def _take_off_wsmp(cursor: _Cursor) -> None:
    """Narrow to the content of a WSMP packet of version 3, subtype 0."""
    if cursor.number() & 0x08:
        _skip_elements(cursor)
    transport = cursor.number()
    if transport > 1:
        raise InputError(f"data must be addressed to a PSID (TPID 0 or 1), had TPID {transport}")
    first = cursor.number()
    if first == 0:  # some units write 00 20 for 20; the PSID 0 has no messages
        first = cursor.number()
    cursor.skip(sum(first >= limit for limit in (0x80, 0xC0, 0xE0)))
    if transport == 1:
        _skip_elements(cursor)
    begin = cursor.begin
    length = _count(cursor)
    if length > cursor.end - cursor.begin and cursor.data[begin] in (0x81, 0x82):
        cursor.begin = begin  # some units write it as IEEE 1609.2 does
        length = _length(cursor)
    cursor.narrow(length)


def _skip_elements(cursor: _Cursor) -> None:
    """Move past WAVE information elements."""
    count = _count(cursor)
    if count > 32:  # IEEE 1609.3 defines fewer than 30
        raise InputError(f"data must have at most 32 information elements, announced {count}")
    for _ in range(count):
        cursor.skip(1)
        cursor.skip(_count(cursor))


def _count(cursor: _Cursor) -> int:
    """Read a count or length of IEEE 1609.3: one byte, or 14 bits after 10."""
    first = cursor.number()
    return first if first < 0x80 else (first & 0x3F) << 8 | cursor.number()


def _length(cursor: _Cursor) -> int:
    """Read a length of IEEE 1609.2: one byte, or the number of bytes that hold it."""
    first = cursor.number()
    return first if first < 0x80 else cursor.number(first & 0x7F)


def _take_off_security(cursor: _Cursor, wrappers: list[str]) -> None:
    """Narrow to the content of unsecured data, or of unsecured data within signed data."""
    for _ in range(_MAX_SECURITY):
        if not _is_security(cursor):
            return
        tag = cursor.number(2) & 0xFF
        if tag == 0x80:
            cursor.narrow(_length(cursor))
            wrappers.append("unsecured")
        elif tag == 0x81:
            _, presence = cursor.number(), cursor.number()  # hash algorithm, then what the payload has
            if not presence & 0x40:
                raise InputError("data must hold its message, had a hash of it in signed data")
            wrappers.append("signed")
        else:
            kind = _NOT_PLAIN.get(tag, f"data of kind {tag:02x}")
            raise InputError(f"data must be unsecured or signed (IEEE 1609.2), was {kind}")
