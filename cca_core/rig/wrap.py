"""Wrappers that a sender puts around a J2735 message, the counterparts of `cca_core.v2x.unwrap_message`."""

from cca_core.errors import InputError

WRAPPERS = ("raw", "unsecured", "wsmp", "rsu")
"""Bare message; unsecured data (IEEE 1609.2); these in WSMP (IEEE 1609.3); text of a roadside unit."""

_PSID = 0x20  # of vehicle-to-vehicle safety messages


def wrap_message(data: bytes, wrapper: str) -> bytes:
    """Put a wrapper around a message.

    Parameters
    ----------
    data : bytes
        A J2735 MessageFrame of less than 16 384 bytes.
    wrapper : {"raw", "unsecured", "wsmp", "rsu"}
        One of `WRAPPERS`.

    Returns
    -------
    wrapped : bytes
        What a radio sends. `cca_core.v2x.unwrap_message` returns the message again.

    Raises
    ------
    InputError
        If the wrapper is unknown or the message is too long.

    Examples
    --------
    >>> from cca_core.v2x import Bsm, encode_bsm, unwrap_message
    >>> frame = encode_bsm(Bsm(msg_count=5, id="00c0ffee"))
    >>> unwrap_message(wrap_message(frame, "wsmp")).wrappers
    ('wsmp', 'unsecured')
    """
    if len(data) > 16_000:
        raise InputError(f"data must have at most 16000 bytes, had {len(data)}")
    if wrapper == "raw":
        return bytes(data)
    if wrapper == "unsecured":
        return _unsecured(data)
    if wrapper == "wsmp":
        content = _unsecured(data)
        return bytes([3, 0, _PSID]) + _wsmp_length(len(content)) + content
    if wrapper == "rsu":
        lines = (
            "Version=0.7", "Type=BSM", f"PSID=0x{_PSID:02x}", "Priority=7", "TxMode=CONT", "TxChannel=183",
            "TxInterval=0", "DeliveryStart=", "DeliveryStop=", "Signature=False", "Encryption=False",
            f"Payload={data.hex().upper()}",
        )  # fmt: skip
        return ("\n".join(lines) + "\n").encode("ascii")
    raise InputError(f"wrapper must be one of {', '.join(WRAPPERS)}, was {wrapper!r}")


def _unsecured(data: bytes) -> bytes:
    """Return Ieee1609Dot2Data of version 3 with unsecured content."""
    n = len(data)
    length = bytes([n]) if n < 0x80 else bytes([0x81, n]) if n < 0x100 else bytes([0x82, n >> 8, n & 0xFF])
    return b"\x03\x80" + length + data


def _wsmp_length(n: int) -> bytes:
    """Return a length of IEEE 1609.3: one byte, or 14 bits after 10."""
    return bytes([n]) if n < 0x80 else bytes([0x80 | n >> 8, n & 0xFF])
