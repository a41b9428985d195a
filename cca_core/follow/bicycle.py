"""Linear single-track model with the lateral error at a preview point as output."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from cca_core._checks import Array, as_array, check_real
from cca_core._repr import short_repr
from cca_core.path import Path
from cca_core.vehicle import VehicleParams, VehicleState


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SingleTrack:
    """Continuous-time model x' = A x + B delta + E kappa with x = [beta, r, e_psi, e_y].

    Parameters
    ----------
    A : ndarray, shape (4, 4)
        Dynamics; rates [1/s] of states in rad, rad/s and m.
    B : ndarray, shape (4,)
        Input: road-wheel angle [rad], left positive.
    E : ndarray, shape (4,)
        Disturbance: path curvature [1/m], left turn positive.
    """

    A: Array
    B: Array
    E: Array

    __repr__ = short_repr


def single_track(vehicle: VehicleParams, v_x: float, l_s: float) -> SingleTrack:
    """Linear single-track model on a path, with preview.

    Parameters
    ----------
    vehicle : VehicleParams
        Geometry, inertia and tires.
    v_x : float
        Forward speed [m/s], positive.
    l_s : float
        Preview distance in front of the center of gravity [m], not negative.

    Returns
    -------
    model : SingleTrack
        States: sideslip beta [rad], yaw rate r [rad/s], heading error e_psi [rad] and lateral error at the
        preview point e_y = h + l_s e_psi [m], left positive.

    Raises
    ------
    InputError
        If `v_x` is not positive or `l_s` is negative.

    Notes
    -----
    beta' and r' are the textbook single-track model with axle stiffnesses;
    e_psi' = r - v kappa and e_y' = v beta + l_s r + v e_psi - l_s v kappa.
    """
    v = check_real("v_x", v_x, gt=0.0)
    l_s = check_real("l_s", l_s, ge=0.0)
    m, inertia = vehicle.m, vehicle.I_z
    moment = vehicle.C_r * vehicle.l_r - vehicle.C_f * vehicle.l_f
    damping = vehicle.C_f * vehicle.l_f**2 + vehicle.C_r * vehicle.l_r**2
    A = np.array(
        [
            [-(vehicle.C_f + vehicle.C_r) / (m * v), moment / (m * v * v) - 1.0, 0.0, 0.0],
            [moment / inertia, -damping / (inertia * v), 0.0, 0.0],
            [0.0, 1.0, 0.0, 0.0],
            [v, l_s, v, 0.0],
        ]
    )
    B = np.array([vehicle.C_f / (m * v), vehicle.C_f * vehicle.l_f / inertia, 0.0, 0.0])
    E = np.array([0.0, 0.0, -v, -l_s * v])
    return SingleTrack(A=A, B=B, E=E)


def discretized(model: SingleTrack, dt: float) -> SingleTrack:
    """Exact discretization for inputs that are held over a cycle.

    Parameters
    ----------
    model : SingleTrack
        Continuous-time model.
    dt : float
        Cycle time [s], positive.

    Returns
    -------
    model : SingleTrack
        x_{k+1} = A x_k + B delta_k + E kappa_k.

    Raises
    ------
    InputError
        If `dt` is not positive.

    Notes
    -----
    The matrix exponential of [[A, B, E], [0, 0, 0]] dt holds A, B and E of the discrete model.
    """
    from scipy.linalg import expm  # slow to import

    dt = check_real("dt", dt, gt=0.0)
    n = len(model.A)
    block = np.zeros((n + 2, n + 2))
    block[:n, :n], block[:n, n], block[:n, n + 1] = model.A, model.B, model.E
    stepped = expm(block * dt)
    return SingleTrack(A=stepped[:n, :n], B=stepped[:n, n], E=stepped[:n, n + 1])


def kinematic_rates(
    psi: ArrayLike, v_x: ArrayLike, delta: ArrayLike, vehicle: VehicleParams
) -> tuple[Array, Array, Array]:
    """Rates of a vehicle whose wheels roll without slip.

    Parameters
    ----------
    psi : array_like, shape (...)
        Heading [rad], counter-clockwise from +x.
    v_x : array_like, shape (...)
        Forward speed [m/s].
    delta : array_like, shape (...)
        Road-wheel angle [rad], left positive.
    vehicle : VehicleParams
        Geometry.

    Returns
    -------
    x_dot, y_dot : ndarray, shape (...)
        Velocity of the center of gravity [m/s].
    r : ndarray, shape (...)
        Yaw rate v tan(delta) / L [rad/s], left positive.

    Raises
    ------
    InputError
        If a value is no array of real numbers.

    Examples
    --------
    >>> float(kinematic_rates(0.0, 10.0, 0.0, VehicleParams.bmw_320i())[0])
    10.0
    """
    psi, v = as_array("psi", psi), as_array("v_x", v_x)
    r = v * np.tan(as_array("delta", delta)) / vehicle.wheelbase
    v_y = vehicle.l_r * r
    return v * np.cos(psi) - v_y * np.sin(psi), v * np.sin(psi) + v_y * np.cos(psi), r


def steady_steering(kappa: ArrayLike, v_x: ArrayLike, vehicle: VehicleParams) -> Array:
    """Road-wheel angle that holds a curvature.

    Parameters
    ----------
    kappa : array_like, shape (...)
        Curvature [1/m], left turn positive.
    v_x : array_like, shape (...)
        Forward speed [m/s].
    vehicle : VehicleParams
        Geometry, mass and tires.

    Returns
    -------
    delta : ndarray, shape (...)
        kappa (L + K v^2) [rad], left positive, K the understeer gradient.

    Raises
    ------
    InputError
        If a value is no array of real numbers.
    """
    gain = vehicle.wheelbase + vehicle.understeer_gradient * np.square(as_array("v_x", v_x))
    return as_array("kappa", kappa) * gain


def steady_sideslip(kappa: ArrayLike, v_x: ArrayLike, vehicle: VehicleParams) -> Array:
    """Sideslip angle in a steady turn.

    Parameters
    ----------
    kappa : array_like, shape (...)
        Curvature [1/m], left turn positive.
    v_x : array_like, shape (...)
        Forward speed [m/s].
    vehicle : VehicleParams
        Geometry, mass and tires.

    Returns
    -------
    beta : ndarray, shape (...)
        kappa (l_r - l_f m v^2 / (C_r L)) [rad], left positive.

    Raises
    ------
    InputError
        If a value is no array of real numbers.
    """
    slope = vehicle.l_f * vehicle.m / (vehicle.C_r * vehicle.wheelbase)
    return as_array("kappa", kappa) * (vehicle.l_r - slope * np.square(as_array("v_x", v_x)))


def steady_yaw_rate(delta: ArrayLike, v_x: ArrayLike, vehicle: VehicleParams) -> Array:
    """Yaw rate in a steady turn.

    Parameters
    ----------
    delta : array_like, shape (...)
        Road-wheel angle [rad], left positive.
    v_x : array_like, shape (...)
        Forward speed [m/s].
    vehicle : VehicleParams
        Geometry, mass and tires.

    Returns
    -------
    r : ndarray, shape (...)
        v delta / (L + K v^2) [rad/s], left turn positive.

    Raises
    ------
    InputError
        If a value is no array of real numbers.
    """
    v = as_array("v_x", v_x)
    rate: Array = v * as_array("delta", delta) / (vehicle.wheelbase + vehicle.understeer_gradient * v**2)
    return rate


def steady_turn(path: Path, s: float, v_x: float, vehicle: VehicleParams) -> VehicleState:
    """Motion of a vehicle that follows a path without error and without transients.

    Parameters
    ----------
    path : Path
        The path.
    s : float
        Station of the center of gravity [m].
    v_x : float
        Forward speed [m/s], not negative.
    vehicle : VehicleParams
        Geometry, mass and tires.

    Returns
    -------
    state : VehicleState
        Steady turn at the curvature there.

    Raises
    ------
    InputError
        If `s` or `v_x` is not finite, or `v_x` negative.
    """
    s, v_x = check_real("s", s), check_real("v_x", v_x, ge=0.0)
    x, y = path.position(s).tolist()
    kappa = path.curvature_at(s)
    beta = float(steady_sideslip(kappa, v_x, vehicle))
    return VehicleState(
        x=x, y=y, psi=float(path.heading(s)) - beta, v_x=v_x, v_y=v_x * beta, r=v_x * kappa,
        delta=float(steady_steering(kappa, v_x, vehicle)),
    )  # fmt: skip
