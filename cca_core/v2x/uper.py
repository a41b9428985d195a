"""Unaligned packed encoding (ITU-T X.691) as far as Basic Safety Messages need it.

Bits are held in one big integer, most significant first; `left` counts the bits not yet read. Whatever the
bytes are, the only thing raised is `InputError`.
"""

from collections.abc import Iterable

from cca_core.errors import InputError

__all__ = ["BitFields", "close_frame", "open_frame", "open_type", "take", "take_open_type"]

_MOST = (1 << 14) - 1  # [B]; longer open types are cut into fragments, which no message of a vehicle needs


class BitFields:
    """Unsigned fields that lie one after the other without gaps.

    Parameters
    ----------
    widths : iterable of int
        Width of each field in bits, first field first.
    """

    def __init__(self, widths: Iterable[int]) -> None:
        self._widths = tuple(widths)
        self.n_bits = sum(self._widths)
        ends = (sum(self._widths[i + 1 :]) for i in range(len(self._widths)))
        self._places = tuple((end, (1 << width) - 1) for end, width in zip(ends, self._widths, strict=True))

    def unpack(self, bits: int) -> list[int]:
        """Cut bits into the fields.

        Parameters
        ----------
        bits : int
            The fields, packed.

        Returns
        -------
        codes : list of int
            One code a field.
        """
        return [bits >> end & mask for end, mask in self._places]

    def pack(self, codes: Iterable[int]) -> int:
        """Put codes one after the other; each must fit its width.

        Parameters
        ----------
        codes : iterable of int
            One code a field.

        Returns
        -------
        bits : int
            The fields, packed.
        """
        bits = 0
        for code, width in zip(codes, self._widths, strict=True):
            bits = bits << width | code
        return bits


def take(bits: int, left: int, width: int) -> tuple[int, int]:
    """Read the next `width` bits.

    Parameters
    ----------
    bits : int
        All bits.
    left : int
        Bits not yet read.
    width : int
        Bits wanted.

    Returns
    -------
    code : int
        What they say.
    left : int
        Bits not yet read after that.

    Raises
    ------
    InputError
        If there are fewer bits than wanted.
    """
    left -= width
    if left < 0:
        raise InputError(f"data must hold what it announces, ended {-left} bits too early")
    return bits >> left & ((1 << width) - 1), left


def take_open_type(bits: int, left: int) -> tuple[int, int, int]:
    """Read the length of an open type and its content, without looking into it.

    Parameters
    ----------
    bits : int
        All bits.
    left : int
        Bits not yet read.

    Returns
    -------
    content : int
        The content as bits.
    n_bits : int
        Length of the content in bits.
    left : int
        Bits not yet read after that.

    Raises
    ------
    InputError
        If the content is cut off, or longer than 16 383 bytes.
    """
    length, left = take(bits, left, 8)
    if length & 0x80:
        if length & 0x40:
            raise InputError(f"data must not hold fragmented parts (longer than {_MOST} bytes)")
        more, left = take(bits, left, 8)
        length = (length & 0x3F) << 8 | more
    content, left = take(bits, left, 8 * length)
    return content, 8 * length, left


def open_type(content: int, n_bits: int) -> tuple[int, int]:
    """Wrap content as an open type: its length in bytes, then the content padded to whole bytes.

    Parameters
    ----------
    content : int
        The content as bits.
    n_bits : int
        Its length in bits, less than 128 bytes.

    Returns
    -------
    bits : int
        Length and content.
    n_bits : int
        Length of that in bits.
    """
    length = (n_bits + 7) // 8
    return length << 8 * length | content << 8 * length - n_bits, 8 + 8 * length


def open_frame(data: bytes | bytearray, message_id: int) -> bytes:
    """Take the message out of a MessageFrame.

    Parameters
    ----------
    data : bytes or bytearray
        The frame. Bytes after its end are ignored, as are later additions to the frame.
    message_id : int
        Kind of message that is wanted.

    Returns
    -------
    body : bytes
        The message.

    Raises
    ------
    InputError
        If `data` is not such a frame, or not all of it.
    """
    if not isinstance(data, (bytes, bytearray)):
        raise InputError(f"data must be bytes, was {type(data).__name__}")
    if len(data) < 3:
        raise InputError(f"data must hold a frame, had {len(data)} bytes")
    found = (data[0] & 0x7F) << 8 | data[1]  # the first bit announces additions
    if found != message_id:
        raise InputError(f"data must hold a message of kind {message_id}, was of kind {found}")
    begin, length = 3, data[2]
    if length & 0x80:
        if length & 0x40 or len(data) < 4:
            raise InputError(f"data must hold a message of at most {_MOST} bytes with its length")
        begin, length = 4, (length & 0x3F) << 8 | data[3]
    if len(data) < begin + length:
        raise InputError(f"data must hold {length} bytes of message, had {len(data) - begin}")
    return bytes(data[begin : begin + length])


def close_frame(bits: int, n_bits: int, message_id: int) -> bytes:
    """Put a message into a MessageFrame.

    Parameters
    ----------
    bits : int
        The message.
    n_bits : int
        Its length in bits, less than 128 bytes.
    message_id : int
        Kind of message.

    Returns
    -------
    data : bytes
        The frame.
    """
    body, width = open_type(bits, n_bits)
    return (message_id << width | body).to_bytes(2 + width // 8, "big")
