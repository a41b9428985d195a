"""Packets in capture files (pcap, pcapng), without the headers that are not of the messages."""

import struct
from collections.abc import Iterator

from cca_core.errors import InputError

__all__ = ["is_capture", "split_capture"]

# magic number: byte order, ticks of the fraction per second
_PCAP = {
    b"\xd4\xc3\xb2\xa1": ("<", 1e6), b"\xa1\xb2\xc3\xd4": (">", 1e6),
    b"\x4d\x3c\xb2\xa1": ("<", 1e9), b"\xa1\xb2\x3c\x4d": (">", 1e9),
}  # fmt: skip
_PCAPNG = b"\x0a\x0d\x0d\x0a"
_SECTION, _INTERFACE, _SIMPLE, _ENHANCED = 0x0A0D0D0A, 1, 3, 6  # types of blocks
_RESOLUTION = 9  # option of an interface
_ETHERNET, _IEEE_802_11, _LINUX, _RADIOTAP = 1, 105, 113, 127
_RAW_IP = 12, 101, 228, 229
_IPV4, _IPV6, _UDP = b"\x08\x00", b"\x86\xdd", 17
_SNAP = b"\xaa\xaa\x03\0\0\0"


def is_capture(data: bytes) -> bool:
    """Return whether the bytes begin like a capture file."""
    return data[:4] in _PCAP or data[:4] == _PCAPNG


def split_capture(data: bytes) -> Iterator[tuple[float | None, bytes]]:
    """Yield the time [s] and the content of each packet; a cut last packet ends the file."""
    for t, link, packet in _pcapng(data) if data[:4] == _PCAPNG else _pcap(data):
        yield t, _content(packet, link)


def _pcap(data: bytes) -> Iterator[tuple[float | None, int, bytes]]:
    order, ticks = _PCAP[data[:4]]
    if len(data) < 24:
        raise InputError(f"a capture file must have a header of 24 bytes, had {len(data)}")
    link, begin = struct.unpack_from(f"{order}I", data, 20)[0] & 0xFFFF, 24
    while begin + 16 <= len(data):
        seconds, fraction, size, _ = struct.unpack_from(f"{order}IIII", data, begin)
        begin += 16
        yield seconds + fraction / ticks, link, data[begin : begin + size]
        begin += size


def _pcapng(data: bytes) -> Iterator[tuple[float | None, int, bytes]]:
    order, begin = "<", 0
    interfaces: list[tuple[int, float]] = []
    while begin + 12 <= len(data):
        if data[begin : begin + 4] == _PCAPNG:
            order, interfaces = ("<" if data[begin + 8 : begin + 12] == b"\x4d\x3c\x2b\x1a" else ">"), []
        kind, size = struct.unpack_from(f"{order}II", data, begin)
        if size < 12:
            raise InputError(f"a capture file must have blocks of at least 12 bytes, had {size}")
        block, begin = data[begin + 8 : begin + size - 4], begin + size
        if kind == _INTERFACE and len(block) >= 8:
            interfaces.append((struct.unpack_from(f"{order}H", block)[0], _ticks(block[8:], order)))
        elif kind == _ENHANCED and len(block) >= 20:
            number, high, low, captured, _ = struct.unpack_from(f"{order}IIIII", block)
            if number < len(interfaces):
                link, ticks = interfaces[number]
                yield (high << 32 | low) / ticks, link, block[20 : 20 + captured]
        elif kind == _SIMPLE and len(block) >= 4 and interfaces:
            yield None, interfaces[0][0], block[4 : 4 + struct.unpack_from(f"{order}I", block)[0]]


def _ticks(options: bytes, order: str) -> float:
    """Return the ticks per second in the options of an interface; microseconds by default."""
    begin = 0
    while begin + 4 <= len(options):
        code, size = struct.unpack_from(f"{order}HH", options, begin)
        if code == _RESOLUTION and size and begin + 4 < len(options):
            power = options[begin + 4]
            return 2.0 ** (power & 0x7F) if power & 0x80 else 10.0**power
        if code == 0:
            break
        begin += 4 + (size + 3) // 4 * 4
    return 1e6


def _content(packet: bytes, link: int) -> bytes:
    """Return the payload of UDP, or from the header on that ends with the EtherType."""
    if link == _RADIOTAP and len(packet) >= 4:
        packet, link = packet[int.from_bytes(packet[2:4], "little") :], _IEEE_802_11
    if link == _IEEE_802_11:
        # the header has 24 bytes, 26 with a field of the quality of service
        begin = packet.find(_SNAP, 24, 40)
        packet = packet if begin < 0 else packet[begin:]
        ether_type, body = packet[6:8], packet[8:]
    elif link == _ETHERNET:
        ether_type, body = packet[12:14], packet[14:]
    elif link == _LINUX:
        ether_type, body = packet[14:16], packet[16:]
        packet = packet[14:]
    elif link in _RAW_IP:
        ether_type, body = (_IPV6 if packet[:1] >= b"\x60" else _IPV4), packet
    else:
        return packet
    if ether_type == b"\x81\x00":  # a virtual network
        packet = body[2:]
        ether_type, body = body[2:4], body[4:]
    if ether_type == _IPV4 and len(body) >= 20 and body[9] == _UDP:
        return body[4 * (body[0] & 0x0F) + 8 :]
    if ether_type == _IPV6 and len(body) >= 40 and body[6] == _UDP:
        return body[48:]
    return packet
