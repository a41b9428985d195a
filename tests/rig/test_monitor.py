"""The monitor: what it counts, how it is served, and its page in a headless browser at two widths."""

import json
import socket
import threading
import time
import urllib.request
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import pytest

from cca_core.real_time import RealTimeLoop
from cca_core.rig import (
    BusLink,
    Codec,
    Frame,
    KitState,
    KitStatus,
    Monitor,
    RigSettings,
    SteeringMap,
    UdpLink,
    encode_telemetry,
    find_scenario,
    serve,
    wrap_message,
)
from cca_core.v2x import Bsm, encode_bsm
from tests.support.browser import Browser, find_browser, open_page
from tests.support.rig_world import RigWorld

pytestmark = [pytest.mark.requires("cantools"), pytest.mark.requires("can")]
BROWSER = find_browser()
SCENARIO = find_scenario("maneuver/2/v2v")
MONITORED = RigSettings(
    bus={"interface": "virtual", "channel": "monitor"}, radio_to_vehicle="239.74.163.3:43301",
    radio_to_plant="239.74.163.3:43302", telemetry_address="239.74.163.3:43303", monitor_port=43304,
)  # fmt: skip
PROBE = """
(() => {
  const canvas = document.getElementById("road");
  const copy = new OffscreenCanvas(canvas.width, canvas.height).getContext("2d", {willReadFrequently: true});
  copy.drawImage(canvas, 0, 0);
  const data = copy.getImageData(0, 0, canvas.width, canvas.height).data;
  const colors = {band: [0, 114, 178], vehicle: [213, 94, 0], line: [136, 136, 136]}, found = {};
  for (const [name, rgb] of Object.entries(colors)) {
    found[name] = 0;
    for (let i = 0; i < data.length; i += 4) {
      if (data[i + 3] > 200 && rgb.every((value, k) => Math.abs(data[i + k] - value) < 25)) found[name]++;
    }
  }
  const texts = [...document.querySelectorAll("h1, p, li, td, caption")];
  return {found, width: innerWidth, page: document.documentElement.scrollWidth,
    font: Math.min(...texts.map((each) => parseFloat(getComputedStyle(each).fontSize))),
    low: document.getElementById("health").getBoundingClientRect().bottom,
    action: document.getElementById("action").textContent,
    reason: document.getElementById("reason").textContent,
    health: [...document.querySelectorAll("#health li")].map((each) => [each.textContent, each.className]),
    text: document.body.innerText};
})()
"""


@pytest.fixture(scope="module")
def world() -> RigWorld:
    """A run in the middle of its evasive maneuver."""
    made = RigWorld(SCENARIO)
    made.run(lambda w: bool(w.plant.rows) and w.state.x != 0.0 and abs(w.d) > 1.0)
    return made


class Senders:
    """A bus with states and spoiled frames, readable and unreadable messages, and telemetry."""

    def __init__(self, world: RigWorld) -> None:
        self.world, self.spoils, self.reports = world, True, True
        self.kit = KitState.ENABLED
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._send)
        self._thread.start()

    def _send(self) -> None:
        codec, bus = Codec(SteeringMap()), BusLink(MONITORED.bus)
        message = wrap_message(encode_bsm(Bsm(msg_count=1, id="00c0ffee")), "wsmp")
        radio, telemetry = (
            UdpLink(None, [a]) for a in (MONITORED.radio_to_vehicle, MONITORED.telemetry_address)
        )
        loop, count = RealTimeLoop(0.02, sleep=lambda _: None), 0
        while not self._stop.wait(0.05):
            count += 1
            status = KitStatus(state=self.kit, cycle=count)
            frames = codec.state_frames(replace(self.world.state, v_x=0.0), status, count)
            bus.send([*frames, *([Frame(codec.ids["STEERING_COMMAND"], bytes(8))] if self.spoils else [])])
            radio.send(message)
            radio.send(b"garbage")
            if self.reports:
                telemetry.send(encode_telemetry(self.world.vehicle, self.world.t, loop))
        for link in (bus, radio, telemetry):
            link.close()

    def close(self) -> None:
        self._stop.set()
        self._thread.join()


@pytest.fixture
def senders(world: RigWorld) -> Iterator[Senders]:
    made = Senders(world)
    yield made
    made.close()


def test_monitor_shows_rates_and_telemetry(senders: Senders) -> None:
    monitor, t = Monitor(SCENARIO, MONITORED), 0.0
    pause = threading.Event()
    while not monitor.snapshot(t)["vehicle"] or "wrong CRC" not in monitor.snapshot(t)["rates"]:
        pause.wait(0.02)
        t += 0.02
        monitor.poll(t)
        assert t < 20.0
    shown = monitor.snapshot(t)
    assert {"EGO_POSE", "KIT_STATUS", "wrong CRC"} <= shown["rates"].keys()
    assert {"radio to_vehicle: BSM", "radio to_vehicle: unreadable"} <= shown["rates"].keys()
    assert shown["vehicle"]["kit"] == "ENABLED"
    assert shown["vehicle"]["action"] == "EVADE_LEFT"
    assert monitor.snapshot(t + 2.0)["rates"] == {}
    monitor.close()


@pytest.fixture
def url(senders: Senders) -> Iterator[str]:
    """Address of the served page."""
    stop = threading.Event()
    thread = threading.Thread(target=serve, args=(SCENARIO, MONITORED), kwargs={"is_stopped": stop.is_set})
    thread.start()
    for _ in range(100):
        try:
            socket.create_connection(("127.0.0.1", MONITORED.monitor_port), 1.0).close()
            break
        except OSError:
            stop.wait(0.05)
    yield f"http://127.0.0.1:{MONITORED.monitor_port}"
    stop.set()
    thread.join(20.0)
    assert not thread.is_alive()


def test_page_is_served_and_ends(url: str) -> None:
    with urllib.request.urlopen(f"{url}/", timeout=20.0) as answer:
        page = answer.read().decode("utf-8")
    with urllib.request.urlopen(f"{url}/road", timeout=20.0) as answer:
        road = json.loads(answer.read())
    with urllib.request.urlopen(f"{url}/events", timeout=20.0) as answer:
        event = answer.readline().decode("utf-8")
    with pytest.raises(urllib.error.HTTPError, match="404"):
        urllib.request.urlopen(f"{url}/secret", timeout=20.0)
    assert "EventSource" in page
    assert "http:" not in page
    assert len(road["lines"]) == 3
    assert event.startswith("data: {")


def probe_until(browser: Browser, word: str) -> dict[str, Any]:
    """State of the page as soon as a health item holds a word."""
    for _ in range(200):
        found: dict[str, Any] = browser.evaluate(PROBE)
        if any(word in text for text, _ in found["health"]):
            return found
        time.sleep(0.1)
    raise AssertionError(f"no {word} in {found['health']}")


@pytest.mark.skipif(BROWSER is None, reason="needs Chromium")
@pytest.mark.parametrize("size", [(1280, 800), (390, 844)], ids=["desk", "phone"])
def test_page_in_browser_shows_road_and_health(senders: Senders, url: str, size: tuple[int, int]) -> None:
    assert BROWSER is not None
    with Browser(BROWSER) as browser:
        open_page(browser, url, size)
        found = probe_until(browser, "bad frames")
        assert found["page"] <= found["width"] == size[0]
        assert found["low"] <= size[1]  # road, action, reason and health without scrolling
        assert found["font"] >= 12.0
        assert min(found["found"].values()) > 100, found["found"]
        assert found["action"] == "EVADE_LEFT"
        assert "R1" in found["reason"]
        assert [text.split(":")[0] for text, _ in found["health"]] == [
            "vehicle",
            "bus",
            "radio",
            "cycle",
            "kit",
        ]
        assert [is_bad for _, is_bad in found["health"]][:3] == ["", "bad", ""]
        assert not any(word in found["text"] for word in ("NaN", "undefined", "null", "Infinity"))
        senders.spoils = False
        assert dict(probe_until(browser, "bus: ok")["health"])["vehicle: ok"] == ""
        senders.reports, senders.kit = False, KitState.SAFE_STOP
        probe_until(browser, "vehicle: silent")
        found = probe_until(browser, "kit: SAFE_STOP")  # from the bus; what came by telemetry is unknown now
        assert [text for text, is_bad in found["health"] if is_bad] == [
            "vehicle: silent", "radio: unknown", "cycle: unknown", "kit: SAFE_STOP"
        ]  # fmt: skip
        assert browser.errors == []
