"""Preview steering: PD control of the lateral error ahead, and feedforward of curvature."""

from copy import copy
from typing import Literal, Self

from cca_core._checks import check_real, formula
from cca_core.errors import InputError
from cca_core.follow.feedforward import InverseSteering
from cca_core.follow.schedule import PreviewGains, shipped_gains
from cca_core.kernel import bind
from cca_core.kernel.memory import lend, put
from cca_core.kernel.steering import Steering, steer
from cca_core.path.path import Path
from cca_core.vehicle import VehicleParams, VehicleState

_steer = bind(steer)
MAX_JUMP = 50.0  # within a cycle, beyond which the vehicle is searched on the whole path [m]


class PreviewController:
    """Steering law delta = delta_ff - k_p (e_y - e_ref) - k_d (e_y' - e_ref') - integral.

    Parameters
    ----------
    vehicle : VehicleParams
        The controlled vehicle.
    gains : PreviewGains, optional
        Schedule over speed; the default is the shipped schedule of this vehicle (`shipped_gains`).
    delay : float
        Known dead time between command and road wheel [s], on top of the steering lag.
    a_y_max : float
        Limit of the commanded lateral acceleration [m/s^2]. It limits the steady turn. Before the vehicle has
        begun to turn it limits the force of the front tires instead, to 80 % of their grip at most.
    error : {"tangent", "ahead"}
        Reference of the error at the preview point: the tangent at the foot point of the center of gravity,
        or the path itself at the preview point.

    Raises
    ------
    InputError
        If an argument is out of range.

    Notes
    -----
    The feedforward delta_ff keeps an ideal car exactly on the path (`InverseSteering`). It uses the curvature
    at the point that the car reaches when the wheels have responded. The ideal car has a sideslip and a yaw
    rate on curves; e_ref is the error of its preview point. The feedback therefore acts only on deviations
    from the model. Three tenths of the sideslip are measured, because load and tires differ from the model.
    For the tangent e_ref is -l_s sin(beta); for the path itself the curvature over the preview distance adds.
    """

    def __init__(
        self,
        vehicle: VehicleParams,
        gains: PreviewGains | None = None,
        *,
        delay: float = 0.0,
        a_y_max: float = 8.0,
        error: Literal["tangent", "ahead"] = "tangent",
    ) -> None:
        if error not in ("tangent", "ahead"):
            raise InputError(f"error must be 'tangent' or 'ahead', was {error!r}")
        self.vehicle = vehicle
        self.gains = gains or shipped_gains(vehicle)
        self.delay = check_real("delay", delay, ge=0.0)
        self.a_y_max = check_real("a_y_max", a_y_max, gt=0.0)
        self._inverse = InverseSteering(vehicle)
        self._law = lend(Steering, count=len(self.gains.speeds))
        law = self._law.workspace
        put(
            law, delta_max=vehicle.delta_max, delta_rate_max=vehicle.delta_rate_max,
            steering_lag=vehicle.steering_lag, understeer=vehicle.understeer_gradient,
            delay=self.delay, a_y_max=self.a_y_max,
        )  # fmt: skip
        law.ahead = error == "ahead"
        for name in ("speeds", "k_p", "k_d", "l_s"):
            self._law.arrays[name][:] = getattr(self.gains, name)
        self._path: Path | None = None
        self._position = 0j

    def __copy__(self) -> Self:
        twin = object.__new__(type(self))
        twin.__dict__ |= self.__dict__ | {"_inverse": copy(self._inverse), "_law": copy(self._law)}
        return twin

    def __repr__(self) -> str:
        return f"PreviewController(gains at {len(self.gains.speeds)} speeds, delay={self.delay:g} s)"

    @formula
    def steer(
        self, state: VehicleState, path: Path, dt: float = 0.02, *, s_guess: float | None = None
    ) -> float:
        """Road-wheel angle for this cycle.

        Parameters
        ----------
        state : VehicleState
            Motion of the vehicle now.
        path : Path
            Path to follow.
        dt : float
            Time since the last call [s].
        s_guess : float, optional
            Station close to the vehicle on a path that is new to the controller [m]; the default searches the
            whole path.

        Returns
        -------
        delta : float
            Road-wheel angle [rad], left positive, within the limits of angle, rate and lateral acceleration.
        """
        law = self._law.workspace
        position, travel = complex(state.x, state.y), max(state.v_x, 0.0) * dt
        if path is self._path and 0.0 <= travel < MAX_JUMP and abs(position - self._position) < MAX_JUMP:
            s_guess = law.s + travel
        elif path is self._path or s_guess is None:
            s_guess = float(path.project((state.x, state.y))[0])
        self._path, self._position = path, position
        return _steer(
            law, self._inverse.car, path.curve, s_guess, state.x, state.y, state.psi, state.v_x, state.v_y,
            state.r, dt,
        )  # fmt: skip
