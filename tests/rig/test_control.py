"""Control port: its lines, and what is no line."""

import threading
from collections.abc import Iterator

import pytest

from cca_core import InputError
from cca_core.rig import ControlPort
from cca_core.rig.__main__ import main

pytestmark = [pytest.mark.requires("cantools"), pytest.mark.requires("can")]
ADDRESS = "127.0.0.1:43331"


@pytest.fixture
def port() -> Iterator[ControlPort]:
    made = ControlPort(ADDRESS)
    yield made
    made.close()


def send(port: ControlPort, *words: str, t: float = 0.0) -> None:
    assert main(["control", ADDRESS, *words]) == 0
    threading.Event().wait(0.01)
    port.poll(t)


def test_driver_steers_until_off(port: ControlPort) -> None:
    assert not port.has_driver
    send(port, "driver", "on")
    assert port.has_driver
    send(port, "driver", "off")
    assert not port.has_driver


def test_utc_error_is_offset_and_drift(port: ControlPort) -> None:
    send(port, "utc", "-5.0")
    assert port.utc_error(100.0) == -5.0
    send(port, "drift", "0.001", t=100.0)
    assert port.utc_error(150.0) == pytest.approx(-4.95)
    assert port.unreadable == 0


@pytest.mark.parametrize(
    "words", [("driver",), ("driver", "perhaps"), ("utc", "nan"), ("utc", "x"), ("drift", "inf"), ("stop",)]
)
def test_other_lines_change_nothing(port: ControlPort, words: tuple[str, ...]) -> None:
    send(port, *words)
    assert (port.has_driver, port.utc_error(1e6), port.unreadable) == (False, 0.0, 1)


def test_closed_port_takes_nothing() -> None:
    port = ControlPort()
    port.poll(0.0)
    assert (port.has_driver, port.utc_error(5.0)) == (False, 0.0)
    port.close()


def test_address_without_port_raises() -> None:
    with pytest.raises(InputError, match="host:port"):
        ControlPort("localhost")
