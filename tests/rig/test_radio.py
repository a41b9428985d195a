"""Radio over UDP: wrappers there and back, groups and addresses, garbage and floods."""

import select

import pytest

from cca_core import InputError
from cca_core.rig import WRAPPERS, UdpLink, wrap_message
from cca_core.v2x import Bsm, encode_bsm, unwrap_message

MESSAGE = encode_bsm(Bsm(msg_count=7, id="00c0ffee", speed=12.0))
WARNING = encode_bsm(Bsm(msg_count=1, id="00c0ffee", events=frozenset({"hard_braking"})))
GROUP, PORT = "239.74.163.3", 43290


@pytest.mark.parametrize("wrapper", WRAPPERS)
@pytest.mark.parametrize("data", [MESSAGE, WARNING])
def test_wrapped_message_is_unwrapped(wrapper: str, data: bytes) -> None:
    frame = unwrap_message(wrap_message(data, wrapper))
    assert (frame.data, frame.name) == (data, "BSM")
    expected = {"raw": (), "unsecured": ("unsecured",), "wsmp": ("wsmp", "unsecured"), "rsu": ("rsu",)}
    assert frame.wrappers == expected[wrapper]


@pytest.mark.parametrize("n", [100, 127, 128, 255, 256, 5000])
@pytest.mark.parametrize("wrapper", WRAPPERS)
def test_lengths_of_wrappers(n: int, wrapper: str) -> None:
    """A message of another kind with n bytes of content."""
    length = bytes([n]) if n < 128 else bytes([0x80 | n >> 8, n & 0xFF])
    data = bytes([0, 31]) + length + bytes(n)
    assert unwrap_message(wrap_message(data, wrapper)).data == data


@pytest.mark.parametrize(
    ("data", "wrapper", "named"), [(b"\0", "paper", "wrapper"), (bytes(20000), "raw", "data")]
)
def test_what_cannot_be_wrapped_raises(data: bytes, wrapper: str, named: str) -> None:
    with pytest.raises(InputError, match=named):
        wrap_message(data, wrapper)


def received(link: UdpLink, n: int) -> list[bytes]:
    """Datagrams that arrive until there are n, or none for some seconds."""
    found: list[bytes] = []
    while len(found) < n and select.select([link], [], [], 5.0)[0]:
        found += link.drain()
    return found


def test_group_is_received_by_all_that_listen() -> None:
    address = f"{GROUP}:{PORT}"
    vehicle, monitor, plant = UdpLink(address), UdpLink(address), UdpLink(send_to=[address])
    sent = [wrap_message(MESSAGE, wrapper) for wrapper in WRAPPERS]
    for data in sent:
        plant.send(data)
    assert received(vehicle, 4) == received(monitor, 4) == sent
    for link in (vehicle, monitor, plant):
        link.close()


def test_unit_is_reached_by_its_address_alone() -> None:
    address = f"127.0.0.1:{PORT + 1}"
    unit, plant = UdpLink(address), UdpLink(send_to=[address])
    plant.send(MESSAGE)
    assert received(unit, 1) == [MESSAGE]
    unit.close()
    for _ in range(3):  # nobody listens any more
        plant.send(MESSAGE)
        assert plant.drain() == []
    plant.close()


def test_flood_is_drained_in_limited_portions() -> None:
    address = f"{GROUP}:{PORT + 2}"
    vehicle, flood = UdpLink(address), UdpLink(send_to=[address])
    for _ in range(120):
        flood.send(b"\xff" * 50)
    assert len(vehicle.drain(50)) <= 50
    vehicle.close()
    flood.close()


@pytest.mark.parametrize("address", ["192.0.2.1:5000", "no.such.host.invalid:1", "127.0.0.1"])
def test_wrong_address_raises(address: str) -> None:
    with pytest.raises(InputError, match="listen"):
        UdpLink(address)
