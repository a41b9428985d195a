"""Floods and random orders of faults on real processes, judged by counts and stations."""

import os
import random
import signal
import socket
import threading
from collections.abc import Callable
from importlib import import_module

import pytest

from cca_core.rig import Frame, UdpLink, find_scenario
from cca_core.sim import Scenario
from tests.support.rig_processes import (
    RIG_MARKS,
    Rig,
    assert_at_rest_in_lanes,
    assert_kit_acts_in_time,
    is_driving,
)

pytestmark = RIG_MARKS
EEBL = find_scenario("eebl/C/v2v")


@pytest.mark.slow
@pytest.mark.parametrize("target", ["bus", "frames", "commands", "radio"])
def test_flood_of_garbage_never_ends_in_collision(start: Callable[[Scenario], Rig], target: str) -> None:
    """Some 10 000 datagrams a second: bytes, foreign frames, or spoiled commands on the bus; bytes on air."""
    rig = start(EEBL)
    rig.until(is_driving)
    stop = threading.Event()
    address = (
        rig.settings.radio_to_vehicle if target == "radio" else f"239.74.163.2:{rig.settings.bus['port']}"
    )
    host, _, port = address.rpartition(":")
    pack = import_module("can.interfaces.udp_multicast.utils").pack_message
    message = import_module("can").Message

    def content() -> bytes:
        if target in ("bus", "radio"):
            return os.urandom(40)
        number = 0x100 + os.urandom(1)[0] % 2 if target == "commands" else 0x300 + os.urandom(1)[0]
        return bytes(pack(message(arbitration_id=number, data=os.urandom(8), is_extended_id=False)))

    def flood() -> None:
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
            sender.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_TTL, 0)
            while not stop.wait(0.01):
                for _ in range(100):
                    sender.sendto(content(), (host, int(port)))

    thread = threading.Thread(target=flood)
    thread.start()
    try:
        rig.until(lambda r: r.v < 0.05)
    finally:
        stop.set()
        thread.join()
    record = rig.finish()
    assert_at_rest_in_lanes(rig, record)
    assert all(row.collided_with == "" for row in record.rows)  # type: ignore[union-attr]


def give_fault(rig: Rig, rng: random.Random) -> None:
    """Give one fault to the processes, on their ports, or on the bus."""
    kind = rng.choice(("stop", "restart", "utc", "drift", "radio", "bus", "commands", "line"))
    if kind == "stop":
        rig.vehicle.send_signal(signal.SIGSTOP)
        rig.count(rng.randint(2, 40))
        rig.vehicle.send_signal(signal.SIGCONT)
    elif kind == "restart":
        rig.vehicle.kill()
        rig.vehicle.wait()
        rig.vehicle = rig.start("vehicle")
    elif kind in ("utc", "drift"):
        size = 5.0 if kind == "utc" else 0.05
        rig.control(rig.settings.vehicle_control, kind, str(rng.uniform(-size, size)))
    elif kind == "commands":
        rig.bus.send([Frame(0x100 + rng.randrange(3), rng.randbytes(rng.randint(0, 8))) for _ in range(200)])
    else:
        port = rig.settings.bus["port"]
        addresses = {
            "radio": rig.settings.radio_to_vehicle, "bus": f"239.74.163.2:{port}",
            "line": rig.settings.vehicle_control,
        }  # fmt: skip
        link = UdpLink(None, [addresses[kind]])
        for _ in range(200):
            link.send(rng.randbytes(rng.randint(0, 60)))
        link.close()


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(3))
def test_random_faults_of_processes_end_in_lanes(start: Callable[[Scenario], Rig], seed: int) -> None:
    rig, rng = start(EEBL), random.Random(seed)
    rig.until(is_driving)
    while rig.receiver.status is not None and rig.receiver.status.cycle < 450:
        give_fault(rig, rng)
        rig.count(rng.randint(3, 30))
        assert rig.vehicle.poll() is None
    rig.vehicle.kill()
    rig.until(lambda r: r.v < 0.05)
    record = rig.finish()
    assert_at_rest_in_lanes(rig, record)
    assert_kit_acts_in_time(record)
    assert all(row.collided_with == "" for row in record.rows)  # type: ignore[union-attr]
