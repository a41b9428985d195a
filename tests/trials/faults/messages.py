"""Ids, senders, clocks and time stamps; messages in wrappers."""

import math
from dataclasses import replace

from cca_core import LocalFrame
from cca_core.v2x import Bsm, Tracker, decode_bsm, encode_bsm
from tests.trials.driving import remote
from tests.trials.faults.scenes import by_radio, clock_off, min_gap, no_traffic, on_lane
from tests.trials.faults.table import Check, Table
from tests.trials.radio import ROAD_HEIGHT

TABLE, WRAPPERS = Table(), Table()


@TABLE.case("ids", "id-twice-in-list", "two records with one id: a car alongside, a stationary car ahead")
def _():
    return min_gap(
        on_lane(15.0, lambda t, _: [remote("0", 55.0 + 15.0 * t, 3.5, 15.0), remote("0", 190.0, 0.0)], 12.0)
    )


@TABLE.case(
    "ids", "id-of-two-senders", "two senders under one temporary id: one alongside, one stationary ahead"
)
def _():
    def world(t, _):
        return [remote("a", 60.0 + 15.0 * t, 3.5, 15.0), remote("b", 300.0, 0.0)]

    return min_gap(by_radio(world, sender=lambda v, t: "00000000"))


@TABLE.case("ids", "id-own-message", "the ego receives its own message, 20 ms late")
def _():
    return [("min speed", by_radio(no_traffic, 5.0, echo=True).minimum("v"), ">=", 14.0)]


@TABLE.case(
    "ids", "sender-27-m-long", "a road train of 27 m is stationary on the lane and reports its length"
)
def _():
    return min_gap(by_radio(lambda t, _: [remote("00000003", 300.0, 0.0, length=27.0, width=2.55)]))


@TABLE.case("ids", "record-45-m-long", "a tram of 45 m is stationary on the lane")
def _():
    return min_gap(on_lane(20.0, lambda t, _: [remote("tram", 190.0, 0.0, length=45.0, width=2.6)], 10.0))


@TABLE.case("ids", "sender-without-heading", "a slow car ahead never reports its heading")
def _():
    return min_gap(
        by_radio(
            lambda t, _: [remote("00000001", 200.0 + 5.0 * t, 0.0, 5.0)], fields=lambda v, t: {"psi": None}
        )
    )


@TABLE.case("ids", "sender-on-a-bridge", "a car on a bridge 8 m above the route; messages report the height")
def _():
    run = by_radio(
        lambda t, _: [remote("00000001", 290.0, 0.0, 0.0, math.pi / 2)],
        12.0,
        fields=lambda v, t: {"elevation": ROAD_HEIGHT + 8.0},
    )
    return [("min speed", run.minimum("v"), ">=", 14.0)]


@TABLE.case("ids", "id-new-after-silence", "the lead sends nothing for 3 s and returns under another id")
def _():
    def sender(vehicle, t):
        return None if 5.0 <= t < 8.0 else f"{11 if t < 5.0 else 12:08x}"

    run = by_radio(lambda t, _: [remote("lead", 150.0 + 15.0 * t, 0.0, 15.0)], 40.0, sender=sender)
    return [("min speed", run.minimum("v"), ">=", 3.0), ("speed at the end", run.last("v"), ">=", 13.0)]


@TABLE.case("ids", "sender-without-gear", "a car backs out of a driveway and does not report its gear")
def _():
    def world(t, _):
        moving = min(max(t - 4.0, 0.0), 6.0)
        return [remote("00000006", 240.0, 18.0 - 3.0 * moving, -3.0 * (0.0 < moving < 6.0), math.pi / 2)]

    return min_gap(by_radio(world, fields=lambda v, t: {"transmission": None}))


@TABLE.case("ids", "bsm-repeated-mark", "hard_braking in a message with the second mark of the one before")
def _():
    tracker = Tracker(LocalFrame(40.0, -83.0))
    for count, mark, events in ((1, 23.8, ()), (2, 23.9, ()), (3, 23.9, ("hard_braking",))):
        bsm = Bsm(
            msg_count=count,
            id="00c0ffee",
            sec_mark=mark,
            latitude_deg=40.0,
            longitude_deg=-83.0 + mark * 1.7e-4,
            speed=14.5,
            psi=0.0,
            a_x=0.0,
            length=4.5,
            width=1.8,
            events=frozenset(events),
        )
        tracker.update(encode_bsm(bsm), 23.75 + 0.1 * count)
    return [("events", sorted(tracker.vehicles(24.06)[0].events), "has", "hard_braking")]


def slowed(limit: float, **how) -> list[Check]:
    """Check that an ego at 20 m/s keeps its speed on an empty road."""
    return [("min speed", on_lane(20.0, no_traffic, 8.0, **how).minimum("v"), ">=", limit)]


@TABLE.case("time", "clock-0.3-s-behind", "the receiver's clock is 0.3 s behind the senders'")
def _():
    return clock_off(-0.3)


@TABLE.case("time", "clock-18-s-ahead", "the receiver's clock is GPS time, the senders' UTC")
def _():
    return clock_off(18.0)


@TABLE.case("time", "time-twice", "one time stamp comes twice")
def _():
    return slowed(19.5, clock=lambda t: 1.98 if abs(t - 2.0) < 1e-6 else t)


@TABLE.case("time", "time-set-back", "the clock is set back by 5 s")
def _():
    return slowed(18.0, clock=lambda t: t - 5.0 * (t > 2.0))


@TABLE.case("time", "place-outlier", "the ego's position jumps 20 m sideways for one cycle")
def _():
    return slowed(19.5, sensed=lambda t, s: replace(s, y=s.y + 20.0) if abs(t - 2.0) < 1e-6 else s)


FRAME = encode_bsm(
    Bsm(msg_count=5, id="00c0ffee", sec_mark=1.0, latitude_deg=40.0, longitude_deg=-83.0, speed=13.9)
)


def wrapped(kind: str, frame: bytes = FRAME, psid: int = 0x20) -> bytes:
    """A message in IEEE 1609.2 unsecured or signed data, or in a WSMP packet (IEEE 1609.3, version 3)."""
    unsecured = bytes((3, 0x80, len(frame))) + frame
    if kind == "signed":  # SHA-256, payload, PSID and generation time, digest of the certificate, signature
        header = bytes((3, 0x81, 0, 0x40)) + unsecured + bytes((0x40, 1, psid)) + bytes(8)
        return header + b"\x80" + bytes(8) + b"\x80\x80" + bytes(64)
    return unsecured if kind == "unsecured" else bytes((3, 0, psid, len(unsecured))) + unsecured


def found(data: bytes) -> list[Check]:
    """Check that the message in a wrapper is found."""
    return [("id", decode_bsm(data).id, "==", "00c0ffee")]


@WRAPPERS.case("wrappers", "bsm-unsecured", "IEEE 1609.2 unsecured data around the message")
def _():
    return found(wrapped("unsecured"))


@WRAPPERS.case("wrappers", "bsm-signed", "IEEE 1609.2 signed data around the message")
def _():
    return found(wrapped("signed"))


@WRAPPERS.case("wrappers", "bsm-wsmp", "a WSMP packet with unsecured data around the message")
def _():
    return found(wrapped("wsmp"))
