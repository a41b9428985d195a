"""Wrappers around messages, encoded by an ASN.1 compiler from the layouts of IEEE 1609.2 and 1609.3."""

from collections.abc import Callable, Iterator, Sequence
from functools import cache, partial
from itertools import product
from typing import Any

import asn1tools

SECURITY = """
Peer DEFINITIONS AUTOMATIC TAGS ::= BEGIN
Secured ::= SEQUENCE { version INTEGER (0..255), content Content }
Content ::= CHOICE { unsecured OCTET STRING, signed Signed, encrypted Encrypted, request OCTET STRING, ... }
Signed ::= SEQUENCE { hash Hash, tbs Tbs, signer Signer, signature Signature }
Hash ::= ENUMERATED { sha256, ..., sha384, sm3 }
Tbs ::= SEQUENCE { payload Payload, header Header }
Payload ::= SEQUENCE { data Secured OPTIONAL, digest Digest OPTIONAL, ..., omitted NULL OPTIONAL }
Digest ::= CHOICE { sha256 OCTET STRING (SIZE (32)), ... }
Header ::= SEQUENCE {
    psid INTEGER (0..MAX), generation INTEGER (0..18446744073709551615) OPTIONAL,
    expiry INTEGER (0..18446744073709551615) OPTIONAL, ... }
Signer ::= CHOICE { digest OCTET STRING (SIZE (8)), certificate OCTET STRING, self NULL, ... }
Signature ::= CHOICE { p256 Ecdsa, ... }
Ecdsa ::= SEQUENCE { r Point, s OCTET STRING (SIZE (32)) }
Point ::= CHOICE { x OCTET STRING (SIZE (32)), fill NULL, odd OCTET STRING (SIZE (32)) }
Encrypted ::= SEQUENCE { recipients OCTET STRING, ciphertext OCTET STRING }
END
"""
PACKET = """
Peer DEFINITIONS AUTOMATIC TAGS ::= BEGIN
Network ::= SEQUENCE { subtype INTEGER (0..15), hasElements BOOLEAN, version INTEGER (0..7) }
Transport ::= SEQUENCE { feature INTEGER (0..127), hasElements BOOLEAN }
Elements ::= SEQUENCE OF SEQUENCE { id INTEGER (0..255), content OCTET STRING }
Body ::= OCTET STRING
END
"""


@cache
def _schema(text: str, codec: str) -> Any:
    return asn1tools.compile_string(text, codec)


def secured(**content: Any) -> bytes:
    """Data of IEEE 1609.2, with one content."""
    return bytes(_security().encode("Secured", {"version": 3, "content": next(iter(content.items()))}))


def _security() -> Any:
    return _schema(SECURITY, "oer")


def unsecured(data: bytes) -> bytes:
    return secured(unsecured=data)


def signed(
    data: bytes | None, *, inner: dict[str, Any] | None = None,
    signer: tuple[str, Any] = ("digest", bytes(8)),
    header: dict[str, Any] | None = None, payload: dict[str, Any] | None = None, hash: str = "sha256",
) -> bytes:  # fmt: skip
    """Signed data around unsecured data, or around another content."""
    within: dict[str, Any] = {} if data is None else {"data": {"version": 3, "content": ("unsecured", data)}}
    if inner is not None:
        within = {"data": {"version": 3, "content": inner}}
    return secured(
        signed={
            "hash": hash,
            "tbs": {"payload": within | (payload or {}), "header": {"psid": 32, **(header or {})}},
            "signer": signer,
            "signature": ("p256", {"r": ("x", bytes(range(32))), "s": bytes(range(32, 64))}),
        }
    )


def psid(number: int) -> bytes:
    """P-encoding of a PSID: the ones before the first zero count the further bytes."""
    for size, first, mark in ((1, 0, 0), (2, 0x80, 0x8000), (3, 0x4080, 0xC00000), (4, 0x204080, 0xE0000000)):
        if number < first + (1 << 7 * size):
            return (number - first | mark).to_bytes(size, "big")
    raise AssertionError(number)


def wsmp(
    data: bytes, number: int = 0x20, elements: Sequence[tuple[int, bytes]] = (),
    more: Sequence[tuple[int, bytes]] = (),
) -> bytes:  # fmt: skip
    """A WSMP packet, with elements in the network header and in the transport header."""
    schema = _schema(PACKET, "uper")

    def coded(items: Sequence[tuple[int, bytes]]) -> bytes:
        listed = [{"id": id, "content": content} for id, content in items]
        return bytes(schema.encode("Elements", listed)) if items else b""

    first = schema.encode("Network", {"subtype": 0, "hasElements": bool(elements), "version": 3})
    transport = schema.encode("Transport", {"feature": 0, "hasElements": bool(more)})
    body = bytes(schema.encode("Body", data))
    return bytes(first + coded(elements) + transport + psid(number) + coded(more) + body)


def ode(data: bytes, source: int = 2, seconds: int = 1_544_018_697, latitude: int = 412_000_000) -> bytes:
    """A record of an on-board unit's log."""
    position = latitude.to_bytes(4, "little", signed=True) + (-1_060_000_000).to_bytes(
        4, "little", signed=True
    )
    motion = (21_000).to_bytes(4, "little") + bytes((1, 2, 3, 4))
    time = seconds.to_bytes(4, "little") + (701).to_bytes(2, "little")
    return bytes((source,)) + position + motion + time + b"\0" + len(data).to_bytes(2, "little") + data


def rsu(data: bytes, end: str = "\n") -> bytes:
    """An immediate forward message in its text form."""
    lines = (
        "Version=0.7", "Type=BSM", "PSID=0x20", "Priority=7", "TxMode=CONT", "TxChannel=172", "TxInterval=0",
        "DeliveryStart=", "DeliveryStop=", "Signature= False", "Encryption=False",
        f"Payload={data.hex().upper()}",
    )  # fmt: skip
    return (end.join(lines) + end).encode()


def ethernet(data: bytes) -> bytes:
    return b"\xff" * 6 + bytes((2, 0x1A, 0, 0, 0, 7)) + b"\x88\xdc" + data


def snap(data: bytes) -> bytes:
    return b"\xaa\xaa\x03\0\0\0\x88\xdc" + data


def signed_by_certificate(data: bytes) -> bytes:
    return signed(data, signer=("certificate", bytes(range(180))), header={"generation": 7, "expiry": 9})


def signed_twice(data: bytes) -> bytes:
    return signed(None, inner=_security().decode("Secured", signed(data))["content"])


def wsmp_elements(data: bytes) -> bytes:
    return wsmp(data, 0x82, ((4, b"\x14"), (15, b"\xac"), (16, bytes(200))), ((200, b""),))


Wrap = Callable[[bytes], bytes]
LINKS: dict[str, Wrap] = {
    "none": bytes, "ethertype": lambda data: b"\x88\xdc" + data, "ethernet": ethernet, "snap": snap,
}  # fmt: skip
PACKETS: dict[str, Wrap] = {
    "none": bytes, "wsmp": wsmp, "wsmp-long-psid": lambda data: wsmp(data, 0x204097),
    "wsmp-elements": wsmp_elements,
}  # fmt: skip
SECURITIES: dict[str, Wrap] = {
    "none": bytes, "unsecured": unsecured, "signed": signed, "signed-certificate": signed_by_certificate,
    "signed-twice": signed_twice,
}  # fmt: skip
OUTER: dict[str, Wrap] = {
    "none": bytes, "hex": lambda data: data.hex().encode(),
    "0x": lambda data: b" 0x" + data.hex().upper().encode() + b"\n", "rsu": rsu,
    "rsu-crlf": lambda data: rsu(data, "\r\n"), "ode": ode, "ode-line": lambda data: ode(data) + b"\n",
}  # fmt: skip


def nestings() -> Iterator[tuple[str, Wrap]]:
    """Names and functions of all ways to wrap a message."""
    for names in product(OUTER, LINKS, PACKETS, SECURITIES):
        if names[1] == "none" or names[2] != "none":  # the EtherType announces a WSMP packet
            layers = (SECURITIES[names[3]], PACKETS[names[2]], LINKS[names[1]], OUTER[names[0]])
            yield "/".join(names), partial(_apply, layers)


def _apply(layers: tuple[Wrap, ...], data: bytes) -> bytes:
    for layer in layers:
        data = layer(data)
    return data
