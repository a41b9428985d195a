"""Drive-by-wire kit: enable, clear, driver override, rate limit, timeout and safe stop."""

import math
from copy import copy
from dataclasses import dataclass
from enum import Enum

from cca_core._checks import check_real
from cca_core._repr import short_repr
from cca_core.rig.safe_stop import StopProfile, StoredStop
from cca_core.vehicle import VehicleState


class KitState(Enum):
    """State of the kit."""

    DISABLED = 0  # the driver drives
    ENABLED = 1  # commands are acted on
    OVERRIDE = 2  # the driver drives until the fault is cleared
    SAFE_STOP = 3  # commands are missing: the last safe stop is executed


@dataclass(frozen=True, slots=True, kw_only=True)
class SteeringCommand:
    """Content of a steering command.

    Parameters
    ----------
    delta : float
        Road-wheel angle [rad], left positive.
    delta_rate : float
        Largest rate at which the kit turns the wheels [rad/s], positive.
    enable : bool
        Whether the sender wants to control the vehicle.
    clear : bool
        Whether the sender asks to clear a safe stop or an override.
    """

    delta: float
    delta_rate: float = math.inf
    enable: bool = False
    clear: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class AccelerationCommand:
    """Content of an acceleration command.

    Parameters
    ----------
    a_x : float
        Acceleration [m/s^2], forward positive.
    enable : bool
        Whether the sender wants to control the vehicle.
    """

    a_x: float
    enable: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class KitSettings:
    """Limits of the kit.

    Parameters
    ----------
    timeout : float
        Age from which on a command counts as missing [s].
    delta_max, delta_rate_max : float
        Largest road-wheel angle [rad] and its largest rate [rad/s].
    a_x_min, a_x_max : float
        Range of accelerations [m/s^2].
    blind_deceleration : float
        Deceleration of a safe stop without a plan, with the wheels held [m/s^2].

    Raises
    ------
    InputError
        If a value is not finite or has the wrong sign.
    """

    timeout: float = 0.1
    delta_max: float = 0.6
    delta_rate_max: float = 0.6
    a_x_min: float = -9.0
    a_x_max: float = 3.0
    blind_deceleration: float = 4.0

    __repr__ = short_repr

    def __post_init__(self) -> None:
        for name in ("timeout", "delta_max", "delta_rate_max", "a_x_max", "blind_deceleration"):
            check_real(name, getattr(self, name), gt=0.0)
        check_real("a_x_min", self.a_x_min, le=0.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class Actuation:
    """What the kit does in a cycle.

    Parameters
    ----------
    delta : float
        Road-wheel angle [rad], left positive.
    a_x : float
        Acceleration [m/s^2], forward positive.
    by_driver : bool
        Whether the driver drives; both values are then those that were measured.
    """

    delta: float
    a_x: float
    by_driver: bool = False


class DriveByWireKit:
    """State machine of a drive-by-wire kit.

    Parameters
    ----------
    settings : KitSettings, optional
        Limits.

    Attributes
    ----------
    settings : KitSettings
        The same.
    state : KitState
        Present state.
    has_timed_out : bool
        Whether the last safe stop was begun for want of a command.

    Notes
    -----
    The kit takes commands that passed the end-to-end check. Its rules are those of common kits:

    - DISABLED becomes ENABLED on an edge: both commands were there without `enable`, then with it.
    - ENABLED becomes SAFE_STOP when one of the commands is older than the timeout, and DISABLED without
      `enable`.
    - The driver overrides ENABLED and SAFE_STOP at once. OVERRIDE becomes DISABLED on an edge of `clear`.
    - SAFE_STOP becomes ENABLED on an edge of `clear` with `enable`, if a safe stop planned since has
      arrived. A process that was restarted has to plan from the measured motion before it may take over.
    - SAFE_STOP executes the safe stop that was the last one when it began: each new one drives on for a
      moment before it brakes, so one after the other would never stop.
    """

    def __init__(self, settings: KitSettings | None = None) -> None:
        self.settings = settings or KitSettings()
        self.state = KitState.DISABLED
        self.has_timed_out = False
        self._steering: tuple[float, SteeringCommand] | None = None
        self._acceleration: tuple[float, AccelerationCommand] | None = None
        self._stop = self._begun = StoredStop()  # the last one, and the one that is executed
        self._is_plan_new = False  # received since the state was entered
        self._seen_disabled: set[str] = set()  # commands without enable since the state was entered
        self._was_not_clear = False  # since then
        self._last: tuple[float, float] | None = None  # time and road-wheel angle of the last actuation

    @property
    def has_plan(self) -> bool:
        """Whether a safe stop is stored."""
        return self._stop.plan is not None

    def steer(self, t: float, command: SteeringCommand) -> None:
        """Take a steering command.

        Parameters
        ----------
        t : float
            Time of reception on the kit's clock [s].
        command : SteeringCommand
            The command; one with a value that is not finite is ignored.
        """
        if math.isfinite(command.delta) and command.delta_rate > 0.0:
            self._steering = t, command
            self._was_not_clear = self._was_not_clear or not command.clear
            self._seen_disabled |= set() if command.enable else {"steering"}

    def accelerate(self, t: float, command: AccelerationCommand) -> None:
        """Take an acceleration command.

        Parameters
        ----------
        t : float
            Time of reception on the kit's clock [s].
        command : AccelerationCommand
            The command; one with a value that is not finite is ignored.
        """
        if math.isfinite(command.a_x):
            self._acceleration = t, command
            self._seen_disabled |= set() if command.enable else {"acceleration"}

    def load(self, t: float, plan: StopProfile) -> None:
        """Store a safe stop that begins at the present position.

        Parameters
        ----------
        t : float
            Time of reception on the kit's clock [s].
        plan : StopProfile
            Executed when commands are missing. In SAFE_STOP the one that has begun goes on.
        """
        self._stop = copy(self._stop)
        self._stop.load(plan, t)
        if self._begun.plan is None:
            self._begun = self._stop
        self._is_plan_new = True

    def step(self, t: float, measured: VehicleState, *, driver_override: bool = False) -> Actuation:
        """Advance by one cycle.

        Parameters
        ----------
        t : float
            Now on the kit's clock [s]; grows from call to call.
        measured : VehicleState
            Motion of the vehicle now.
        driver_override : bool
            Whether the driver steers or brakes.

        Returns
        -------
        actuation : Actuation
            Steering and acceleration until the next cycle.
        """
        dt = 0.0 if self._last is None else min(max(t - self._last[0], 0.0), 1.0)
        for stop in {id(stop): stop for stop in (self._stop, self._begun)}.values():
            stop.move(max(measured.v_x, 0.0), measured.r, t)
        self._enter(self._next_state(t, driver_override))
        if self.state in (KitState.DISABLED, KitState.OVERRIDE):
            actuation = Actuation(delta=measured.delta, a_x=measured.a_x, by_driver=True)
        elif self.state is KitState.ENABLED and self._steering and self._acceleration:
            steering, a_x = self._steering[1], self._acceleration[1].a_x
            actuation = self._limited(steering.delta, a_x, dt, steering.delta_rate)
        else:
            held = measured.delta if self._last is None else self._last[1]
            blind = held, -self.settings.blind_deceleration
            actuation = self._limited(*(self._begun.execute() or blind), dt)
        self._last = t, actuation.delta
        return actuation

    def _next_state(self, t: float, driver_override: bool) -> KitState:
        if self.state is KitState.DISABLED:
            has_edge = self._has_enable() and len(self._seen_disabled) == 2
            enabled = self._is_fresh(t) and has_edge and not driver_override
            return KitState.ENABLED if enabled else KitState.DISABLED
        if driver_override:
            return KitState.OVERRIDE
        if self.state is KitState.ENABLED:
            if not self._is_fresh(t):
                return KitState.SAFE_STOP
            return KitState.ENABLED if self._has_enable() else KitState.DISABLED
        if not (self._is_fresh(t) and self._is_cleared()):
            return self.state
        if self.state is KitState.OVERRIDE:
            return KitState.DISABLED
        return KitState.ENABLED if self._has_enable() and self._is_plan_new else KitState.SAFE_STOP

    def _enter(self, state: KitState) -> None:
        if state is not self.state:
            self.has_timed_out = state is KitState.SAFE_STOP
            self._seen_disabled = set()
            self._was_not_clear = self._is_plan_new = False
            self._begun = self._stop
            self.state = state

    def _is_fresh(self, t: float) -> bool:
        commands = self._steering, self._acceleration
        return all(c is not None and 0.0 <= t - c[0] <= self.settings.timeout for c in commands)

    def _has_enable(self) -> bool:
        commands = self._steering, self._acceleration
        return all(c is not None and c[1].enable for c in commands)

    def _is_cleared(self) -> bool:
        return self._was_not_clear and self._steering is not None and self._steering[1].clear

    def _limited(self, delta: float, a_x: float, dt: float, rate: float = math.inf) -> Actuation:
        """Return what is asked for within the limits."""
        s = self.settings
        delta = min(max(delta, -s.delta_max), s.delta_max)
        if self._last is not None:
            step = min(rate, s.delta_rate_max) * dt
            delta = min(max(delta, self._last[1] - step), self._last[1] + step)
        return Actuation(delta=delta, a_x=min(max(a_x, s.a_x_min), s.a_x_max))
