"""Scene of a decision: the route, candidate paths, other vehicles, and motions of the ego along the paths."""

from typing import Annotated

from cca_core.kernel.types import Flag, Grid, Int, Ints, Real, Reals, floor_within

OnRoute = Annotated[Reals, "n"]
OnPaths = Annotated[Grid, "max_paths", "n"]
PerPath = Annotated[Reals, "max_paths"]
Overtakes = Annotated[Grid, "max_paths", "max_m"]
Times = Annotated[Reals, "steps"]
Motions = Annotated[Grid, "max_m", "steps"]
PerVehicle = Annotated[Reals, "max_m"]
VehicleMarks = Annotated[Ints, "max_m"]
Runs = Annotated[Grid, "max_rows", "steps"]
RunMarks = Annotated[Ints, "max_rows"]
Terms = Annotated[Grid, "max_rows", 9]
Stops = Annotated[Reals, 8]
OtherLanes = Annotated[Grid, "max_lanes", 2]
Seen = Annotated[Grid, "max_m", 27]

TOLERANCE = 0.05  # beyond a lane boundary, up to which the body is in its lane [m]


class Scene:
    """Route, candidate paths, other vehicles, the ego and its motions of one decision."""

    # the route around the ego, one station a meter; stations are relative to the first
    n: Int
    max_m: Int
    max_paths: Int
    max_rows: Int
    steps: Int
    max_lanes: Int
    x: OnRoute
    y: OnRoute
    psi: OnRoute
    kappa: OnRoute
    cap: OnRoute  # squared speed limit
    lane_right: Real
    lane_left: Real
    edge_right: Real  # far boundaries of the adjacent lanes
    edge_left: Real
    other_lanes: OtherLanes  # right and left boundary of each
    # candidate paths: lateral offset, squared speed limit, vehicles that are overtaken
    d: OnPaths
    path_cap: OnPaths
    path_low: PerPath  # least and largest lateral offset
    path_high: PerPath
    end_right: PerPath  # boundaries of the lane in which each ends
    end_left: PerPath
    overtakes: Overtakes
    # times from now
    t: Times
    # other vehicles: nominal motion and worst case; those that cross the route in the plane
    m: Int
    seen: Seen  # see the columns of `kernel.traffic`
    s_o: Motions
    v_o: Motions
    d_o: Motions
    s_follow: Motions  # where vehicles do not drive through each other
    v_follow: Motions
    half_l: PerVehicle
    half_w: PerVehicle
    low: Motions
    high: Motions
    high_passed: Motions  # of a vehicle that is overtaken
    low_passed: Motions  # the same of an oncoming one
    right: Motions
    left: Motions
    d_low: PerVehicle  # least and largest of `d_o`
    d_high: PerVehicle
    order: VehicleMarks  # of those that follow each other
    leads: VehicleMarks  # those that a path may meet
    met: VehicleMarks  # step at which the ego meets them
    crossing: Int  # number of those that cross
    # conflicts with those that cross: from which to which station, and when
    s_enter: PerVehicle
    s_exit: PerVehicle
    t_enter: PerVehicle
    t_exit: PerVehicle
    crosses: VehicleMarks
    stands: VehicleMarks
    passing_distance: PerVehicle  # kept behind a vehicle that can be passed later [m]
    x_o: Motions
    y_o: Motions
    psi_o: Motions
    x_w: Motions
    y_w: Motions
    psi_w: Motions
    half_l_w: Motions
    half_w_w: Motions
    adjacent: VehicleMarks  # lanes that it may be in: 1 left, 2 right, 3 both
    assumed: VehicleMarks  # at the end of the awareness range
    # what is assumed of others; `b_other` is the braking
    v_limit: Real
    a_other: Real
    a_passed: Real
    b_crossing: Real
    a_crossing: Real
    min_pet: Real
    braking_time: Real
    acceleration_time: Real
    crossing_time: Real  # the same of vehicles that cross
    yield_time: Real  # for which one that crosses goes on braking in the worst case
    keeps: Flag  # whether all keep their motion
    entry_tolerance: Real
    queue_gap: Real
    passing_gap: Real
    # points to stop at for vehicles that cross, in the order of their arrival
    stops: Int
    stop_s: Stops
    stop_until: Stops
    # the ego
    s_0: Real
    v_0: Real
    a_0: Real
    a_true: Real
    half_length: Real
    half_width: Real
    offset: Real
    # its limits
    a_max: Real
    b_comfort: Real
    b_max: Real
    b_soft: Real  # needed deceleration from which on following costs
    b_other: Real  # that others may brake with
    risk_until: Real
    grip: Real
    standstill_gap: Real
    time_gap: Real
    approach_rate: Real
    jerk: Real
    jerk_emergency: Real
    lag: Real
    blocking_gap: Real
    opening_speed: Real
    creep_time: Real
    b_firm: Real  # for the distance to pass a vehicle later
    look: Real
    react: Real
    margin: Real  # along the road, which a new plan keeps beyond the worst case [m]
    # motions of the ego
    s: Runs
    v: Runs
    a: Runs
    offset_at: Runs
    limited_by: RunMarks
    terms: Terms
    # the ego's body in a motion and on a path: center, cosine and sine of the heading; blocks of a path
    turn: Times
    scale: Times
    wide: Times
    bends: Times  # largest curvature of the route near the body
    x_e: Times
    y_e: Times
    c_e: Times
    s_e: Times
    x_p: OnRoute
    y_p: OnRoute
    c_p: OnRoute
    s_p: OnRoute
    x_b: OnRoute
    y_b: OnRoute
    r_b: OnRoute
    # results of the last check
    min_margin: Real
    gap: Real
    which: Int
    when: Int
    impact: Real
    zone_from: Real  # time at which the body enters an adjacent lane
    begin_from: Real  # and at which that maneuver begins
    zone_side: Int  # of that lane: 1 left, 2 right
    rear_reaction: Real  # of drivers behind in that lane [s]; 0 if they do not react
    rear_braking: Real
    # lanes that the ego is in while it is outside its own, so that drivers behind keep their distance there
    established: Int  # 1 left, 2 right; 0 if it is in its lane, or if drivers do not react
    leaves: Flag  # whether it is partly in its own lane as well
    duty_from: Int
    rear: Real


def station(n: Int, at: Real) -> Int:
    """Index of the station before a position on the route."""
    return floor_within(at, 0, n - 2)


def at_station(n: Int, row: OnRoute, at: Real) -> Real:
    """Value at a position, linear between stations."""
    i = station(n, at)
    f = min(max(at - i, 0.0), 1.0)
    return row[i] + f * (row[i + 1] - row[i])


def lateral(w: Scene, p: Int, at: Real) -> Real:
    """Lateral offset of a path."""
    i = station(w.n, at)
    f = min(max(at - i, 0.0), 1.0)
    return w.d[p, i] + f * (w.d[p, i + 1] - w.d[p, i])


def slope(w: Scene, p: Int, at: Real) -> Real:
    """Slope of the lateral offset of a path."""
    return 0.5 * (lateral(w, p, at + 1.0) - lateral(w, p, at - 1.0))


def bend(w: Scene, p: Int, at: Real) -> Real:
    """Curvature that a path adds to the route's."""
    return lateral(w, p, at + 1.0) - 2.0 * lateral(w, p, at) + lateral(w, p, at - 1.0)


def squared_speed(w: Scene, p: Int, at: Real) -> Real:
    """Squared speed limit of route and path."""
    i = station(w.n, at)
    f = min(max(at - i, 0.0), 1.0)
    own = w.path_cap[p, i] + f * (w.path_cap[p, i + 1] - w.path_cap[p, i])
    return min(own, w.cap[i] + f * (w.cap[i + 1] - w.cap[i]))


def is_outside(w: Scene, p: Int, d: Real, tolerance: Real) -> Flag:
    """Whether a body is wholly inside neither the ego lane nor the lane in which a path ends."""
    left = d + w.half_width - tolerance
    right = d - w.half_width + tolerance
    if left > w.lane_left or right < w.lane_right:
        return left > w.end_left[p] or right < w.end_right[p]
    return False
