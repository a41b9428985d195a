"""Unaligned packed encoding (ITU-T X.691) of Basic Safety Messages."""

from collections.abc import Iterable

from cca_core.errors import InputError

__all__ = ["BitFields", "close_frame", "frame_extent", "open_frame", "open_type", "take", "take_open_type"]

# bits are one big integer, most significant first; `left` counts the bits not yet read
_MAX_BYTES = (1 << 14) - 1  # longer open types are fragmented; no Basic Safety Message needs that


class BitFields:
    """Unsigned fields of given widths in bits, one after the other without gaps."""

    def __init__(self, widths: Iterable[int]) -> None:
        self._widths = tuple(widths)
        self.n_bits = sum(self._widths)
        ends = (sum(self._widths[i + 1 :]) for i in range(len(self._widths)))
        self._positions = tuple(
            (end, (1 << width) - 1) for end, width in zip(ends, self._widths, strict=True)
        )

    def unpack(self, bits: int) -> list[int]:
        """Cut bits into the codes of the fields."""
        return [bits >> end & mask for end, mask in self._positions]

    def pack(self, codes: Iterable[int]) -> int:
        """Join codes; each must fit its width."""
        bits = 0
        for code, width in zip(codes, self._widths, strict=True):
            bits = bits << width | code
        return bits


def take(bits: int, left: int, width: int) -> tuple[int, int]:
    """Read the next bits; return their code and the number of bits left."""
    left -= width
    if left < 0:
        raise InputError(f"data must hold what it announces, ended {-left} bits too early")
    return bits >> left & ((1 << width) - 1), left


def take_open_type(bits: int, left: int) -> tuple[int, int, int]:
    """Read an open type; return its content, its length in bits and the number of bits left."""
    length, left = take(bits, left, 8)
    if length & 0x80:
        if length & 0x40:
            raise InputError(f"data must not hold fragmented parts (longer than {_MAX_BYTES} bytes)")
        more, left = take(bits, left, 8)
        length = (length & 0x3F) << 8 | more
    content, left = take(bits, left, 8 * length)
    return content, 8 * length, left


def open_type(content: int, n_bits: int) -> tuple[int, int]:
    """Wrap content of less than 128 bytes as an open type; return its bits and their number."""
    length = (n_bits + 7) // 8
    return length << 8 * length | content << 8 * length - n_bits, 8 + 8 * length


def frame_extent(data: bytes | bytearray, begin: int, end: int) -> tuple[int, int, int]:
    """Return the kind of the MessageFrame at `begin`, and where its message begins and ends."""
    if end - begin < 3:
        raise InputError(f"data must hold a frame, had {end - begin} bytes")
    found = (data[begin] & 0x7F) << 8 | data[begin + 1]  # the first bit announces additions
    start, length = begin + 3, data[begin + 2]
    if length & 0x80:
        if length & 0x40 or end - begin < 4:
            raise InputError(f"data must hold a message of at most {_MAX_BYTES} bytes with its length")
        start, length = begin + 4, (length & 0x3F) << 8 | data[begin + 3]
    if end < start + length:
        raise InputError(f"data must hold {length} bytes of message, had {end - start}")
    return found, start, start + length


def open_frame(data: bytes | bytearray, message_id: int) -> bytes:
    """Return the message of a MessageFrame; bytes after its end are ignored."""
    found, begin, end = frame_extent(data, 0, len(data))
    if found != message_id:
        raise InputError(f"data must hold a message of kind {message_id}, was of kind {found}")
    return bytes(data[begin:end])


def close_frame(bits: int, n_bits: int, message_id: int) -> bytes:
    """Return the MessageFrame of a message of less than 128 bytes."""
    body, width = open_type(bits, n_bits)
    return (message_id << width | body).to_bytes(2 + width // 8, "big")
