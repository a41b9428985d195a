"""Drive-by-wire kit: its transitions one by one, and random orders of faults in virtual time."""

import math
import random
from dataclasses import dataclass, field, replace

import pytest

from cca_core import InputError, VehicleState
from cca_core.rig import (
    AccelerationCommand,
    Actuation,
    DriveByWireKit,
    KitSettings,
    KitState,
    LinkState,
    ProtectedReceiver,
    SteeringCommand,
    StopProfile,
    protect,
)

CYCLE = 0.02
MOTION = VehicleState(x=0.0, y=0.0, psi=0.0, v_x=20.0, delta=0.01, a_x=0.3)
PLAN = StopProfile(spacing=1.0, heading=(0.0,) * 40, delta=(0.05,) * 40, a_x=(-6.0,) * 40)
ALLOWED = {
    KitState.DISABLED: {KitState.ENABLED},
    KitState.ENABLED: {KitState.DISABLED, KitState.OVERRIDE, KitState.SAFE_STOP},
    KitState.OVERRIDE: {KitState.DISABLED},
    KitState.SAFE_STOP: {KitState.ENABLED, KitState.OVERRIDE},
}


def command(
    kit: DriveByWireKit, t: float, *, enable: bool = True, clear: bool = False, **values: float
) -> None:
    kit.steer(t, SteeringCommand(delta=values.get("delta", 0.0), enable=enable, clear=clear))
    kit.accelerate(t, AccelerationCommand(a_x=values.get("a_x", 0.0), enable=enable))


def enabled_kit(t: float = 0.0) -> DriveByWireKit:
    """A kit that has just been enabled at a time."""
    kit = DriveByWireKit()
    command(kit, t - CYCLE, enable=False)
    kit.step(t - CYCLE, MOTION)
    command(kit, t)
    kit.step(t, MOTION)
    assert kit.state is KitState.ENABLED
    return kit


def stopping_kit(t: float = 0.2, plan: StopProfile | None = PLAN) -> DriveByWireKit:
    """A kit that has just begun a safe stop at a time."""
    kit = enabled_kit()
    if plan is not None:
        kit.load(0.0, plan)
    kit.step(t, MOTION)
    assert kit.state is KitState.SAFE_STOP
    return kit


def test_driver_drives_while_disabled() -> None:
    kit = DriveByWireKit()
    assert kit.step(0.0, MOTION) == Actuation(delta=0.01, a_x=0.3, by_driver=True)


def test_enable_without_edge_is_ignored() -> None:
    kit = DriveByWireKit()
    for k in range(20):
        command(kit, k * CYCLE)
        kit.step(k * CYCLE, MOTION)
    assert kit.state is KitState.DISABLED


def test_edge_of_enable_enables_and_enable_off_disables() -> None:
    kit = enabled_kit()
    command(kit, CYCLE, enable=False)
    kit.step(CYCLE, MOTION)
    assert kit.state is KitState.DISABLED


def test_one_command_without_enable_does_not_enable() -> None:
    kit = DriveByWireKit()
    command(kit, 0.0, enable=False)
    kit.step(0.0, MOTION)
    kit.steer(CYCLE, SteeringCommand(delta=0.0, enable=True))
    kit.step(CYCLE, MOTION)
    assert kit.state is KitState.DISABLED


@pytest.mark.parametrize("missing", ["steering", "acceleration", "both"])
def test_missing_command_times_out(missing: str) -> None:
    kit, t = enabled_kit(), 0.0
    while kit.state is KitState.ENABLED:
        t += CYCLE
        if missing == "steering":
            kit.accelerate(t, AccelerationCommand(a_x=0.0, enable=True))
        elif missing == "acceleration":
            kit.steer(t, SteeringCommand(delta=0.0, enable=True))
        kit.step(t, MOTION)
    assert kit.state is KitState.SAFE_STOP
    assert kit.has_timed_out
    assert kit.settings.timeout < t <= kit.settings.timeout + 2 * CYCLE


def test_safe_stop_follows_plan_by_distance() -> None:
    plan = replace(PLAN, delta=tuple(0.001 * i for i in range(40)))
    kit, t = stopping_kit(plan=plan), 0.2
    for k in range(1, 40):
        t = 0.2 + k * CYCLE
        actuation = kit.step(t, MOTION)
    # 20 m/s from the load at t = 0 on: the kit has stepped at 0.2 s and later
    assert actuation.delta == pytest.approx(min(0.001 * 20.0 * t, 0.039))
    assert actuation.a_x == -6.0


@pytest.mark.parametrize("yaw_rate", [-0.02, 0.02])
def test_safe_stop_steers_against_measured_deviation(yaw_rate: float) -> None:
    """The plan is straight, the vehicle turns."""
    kit = stopping_kit(plan=replace(PLAN, delta=(0.0,) * 40))
    for k in range(1, 30):
        actuation = kit.step(0.2 + k * CYCLE, replace(MOTION, r=yaw_rate))
    assert -0.031 <= actuation.delta * math.copysign(1.0, yaw_rate) < -0.001


def test_safe_stop_that_has_begun_is_not_replaced() -> None:
    """Each new one drives on for a moment: one after the other would never brake."""
    kit = stopping_kit()
    for k in range(1, 40):
        t = 0.2 + k * CYCLE
        command(kit, t)
        kit.load(t, replace(PLAN, a_x=(0.0,) * 39 + (-6.0,)))
        assert kit.step(t, MOTION).a_x == -6.0
    assert kit.state is KitState.SAFE_STOP


def test_safe_stop_without_plan_brakes_with_wheels_held() -> None:
    kit = stopping_kit(plan=None)
    actuation = kit.step(0.22, MOTION)
    assert actuation.a_x == -kit.settings.blind_deceleration
    assert actuation.delta == kit.step(0.24, MOTION).delta


def test_fresh_commands_do_not_end_safe_stop() -> None:
    kit = stopping_kit()
    for k in range(20):
        command(kit, 0.22 + k * CYCLE)
        kit.step(0.22 + k * CYCLE, MOTION)
    assert kit.state is KitState.SAFE_STOP


@pytest.mark.parametrize(("replanned", "state"), [(True, KitState.ENABLED), (False, KitState.SAFE_STOP)])
def test_clear_needs_plan_made_since_safe_stop(replanned: bool, state: KitState) -> None:
    kit = stopping_kit()
    command(kit, 0.22)
    kit.step(0.22, MOTION)
    if replanned:
        kit.load(0.22, PLAN)
    command(kit, 0.24, clear=True)
    kit.step(0.24, MOTION)
    assert kit.state is state


def test_clear_without_edge_is_ignored() -> None:
    kit = stopping_kit()
    kit.load(0.22, PLAN)
    for k in range(10):
        command(kit, 0.22 + k * CYCLE, clear=True)
        kit.step(0.22 + k * CYCLE, MOTION)
    assert kit.state is KitState.SAFE_STOP


@pytest.mark.parametrize("state", [KitState.ENABLED, KitState.SAFE_STOP])
def test_driver_overrides_within_same_cycle(state: KitState) -> None:
    kit = enabled_kit() if state is KitState.ENABLED else stopping_kit()
    actuation = kit.step(0.25, MOTION, driver_override=True)
    assert kit.state is KitState.OVERRIDE
    assert actuation.by_driver


def test_override_needs_clear_and_then_enable_edge() -> None:
    kit = enabled_kit()
    kit.step(CYCLE, MOTION, driver_override=True)
    seen = []
    for k, (enable, clear) in enumerate([(1, 0), (1, 1), (1, 0), (0, 0), (1, 0)]):
        t = 2 * CYCLE + k * CYCLE
        command(kit, t, enable=bool(enable), clear=bool(clear))
        kit.step(t, MOTION)
        seen.append(kit.state.name)
    assert seen == ["OVERRIDE", "DISABLED", "DISABLED", "DISABLED", "ENABLED"]


def test_angle_rate_and_acceleration_are_limited() -> None:
    kit = enabled_kit()
    command(kit, CYCLE, delta=5.0, a_x=50.0)
    actuation = kit.step(CYCLE, MOTION)
    s = kit.settings
    assert actuation.delta == pytest.approx(s.delta_rate_max * CYCLE)
    assert actuation.a_x == s.a_x_max
    for k in range(2, 200):
        command(kit, k * CYCLE, delta=5.0, a_x=-50.0)
        actuation = kit.step(k * CYCLE, MOTION)
    assert actuation == Actuation(delta=s.delta_max, a_x=s.a_x_min)


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
def test_command_that_is_not_finite_is_ignored(value: float) -> None:
    kit = enabled_kit()
    for k in range(1, 9):
        command(kit, k * CYCLE, delta=value, a_x=value)
        actuation = kit.step(k * CYCLE, MOTION)
        assert math.isfinite(actuation.delta + actuation.a_x)
    assert kit.state is KitState.SAFE_STOP


def test_settings_out_of_range_raise() -> None:
    with pytest.raises(InputError, match="timeout"):
        KitSettings(timeout=0.0)


@dataclass
class Sender:
    """Vehicle computer in virtual time: protected commands, and faults on their way to the kit."""

    rng: random.Random
    counter: int = 0
    enable: bool = False
    clear: bool = False
    delayed: list[tuple[float, int, bytes]] = field(default_factory=list)

    def send(self, t: float, fault: str, state: KitState) -> list[tuple[int, bytes]]:
        """Frames that arrive at the kit now, of data ids 1 (steering) and 2 (acceleration)."""
        if self.rng.random() < 0.3:
            self.enable = self.rng.random() < 0.8
        self.clear = state in (KitState.SAFE_STOP, KitState.OVERRIDE) and self.rng.random() < 0.5
        self.counter += 0 if fault == "repeat" else self.rng.randint(3, 12) if fault == "jump" else 1
        frames = []
        for data_id in (1, 2):
            # byte 2: the sender's wish; byte 3: 1 marks content that must never be acted on
            body = bytes([0, 0, self.enable << 1 | self.clear, fault in ("crc", "masquerade"), 0, 0, 0, 0])
            data = protect(body, data_id + 2 * (fault == "masquerade"), self.counter)
            if fault == "crc":
                data = bytes([data[0] ^ self.rng.randint(1, 255)]) + data[1:]
            if fault == "late":
                self.delayed.append((t + self.rng.uniform(0.02, 0.3), data_id, data))
            elif fault != "lost" and not (fault == "half" and data_id == 2):
                frames += [(data_id, data)] * (3 if fault == "twice" else 1)
        due = [(i, data) for at, i, data in self.delayed if at <= t]
        self.delayed = [each for each in self.delayed if each[0] > t]
        return due + frames


FAULTS = (
    "crc", "masquerade", "repeat", "jump", "late", "lost", "half", "twice", "stall", "kit_stall", "override",
)  # fmt: skip


def drive_with_faults(seed: int, cycles: int = 150) -> set[KitState]:
    """Check every rule of the kit in each cycle of a random order of faults; return the states seen."""
    rng = random.Random(seed)
    kit, sender = DriveByWireKit(), Sender(rng)
    links = {1: ProtectedReceiver(1), 2: ProtectedReceiver(2)}
    valid = {1: -math.inf, 2: -math.inf}  # time of the last command that was acted on
    fault, until, t, seen, last = "none", 0.0, 0.0, set(), None
    for _ in range(cycles):
        dt = CYCLE * (1.0 + 0.2 * rng.random())
        if t >= until:
            fault = rng.choice(FAULTS) if rng.random() < 0.5 else "none"
            until = t + rng.choice((CYCLE, 0.08, 0.15, 0.4))
        if fault == "kit_stall" and rng.random() < 0.2:
            dt += rng.uniform(0.05, 0.5)
        t += dt
        frames = [] if fault == "stall" else sender.send(t, fault, kit.state)
        for data_id, link in links.items():
            arrived = [data for i, data in frames if i == data_id]
            for data in arrived or [None]:
                if link.check(data).is_usable and link.state is LinkState.VALID:
                    assert data is not None
                    assert data[3] == 0, "content of a faulty message"
                    valid[data_id] = t
                    wish, clear = bool(data[2] >> 1), bool(data[2] & 1)
                    if data_id == 1:
                        kit.steer(t, SteeringCommand(delta=rng.uniform(-0.3, 0.3), enable=wish, clear=clear))
                    else:
                        kit.accelerate(t, AccelerationCommand(a_x=rng.uniform(-7.0, 2.0), enable=wish))
        if rng.random() < 0.2:
            kit.load(t, PLAN)
        override, before = fault == "override", kit.state
        actuation = kit.step(t, MOTION, driver_override=override)
        after = kit.state
        assert after is before or after in ALLOWED[before]
        assert math.isfinite(actuation.delta + actuation.a_x)
        assert actuation.by_driver == (after in (KitState.DISABLED, KitState.OVERRIDE))
        age = t - min(valid.values())
        if after is KitState.ENABLED:
            assert age <= kit.settings.timeout
        if before is KitState.ENABLED and age > kit.settings.timeout and not override:
            assert after is KitState.SAFE_STOP
        if override:
            assert after in (KitState.DISABLED, KitState.OVERRIDE)
        if after is KitState.SAFE_STOP:
            assert actuation.a_x in (-6.0, -kit.settings.blind_deceleration)
        if last is not None and not actuation.by_driver:
            assert abs(actuation.delta - last) <= kit.settings.delta_rate_max * dt + 1e-12
        last = actuation.delta
        seen.add(after)
    return seen


def test_random_orders_of_faults_keep_all_rules() -> None:
    seen = [drive_with_faults(seed) for seed in range(300)]
    for state in KitState:
        assert sum(state in each for each in seen) > 100, state


@pytest.mark.slow
def test_ten_thousand_orders_of_faults_keep_all_rules() -> None:
    for seed in range(300, 10_300):
        drive_with_faults(seed)
