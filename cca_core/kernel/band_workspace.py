"""Memory of a band in the kernel: codes, the equilibrium, one band, and a batch of bands."""

from typing import Annotated

from cca_core.kernel.types import Flag, Grid, Int, Ints, Real, Reals

Nodes = Annotated[Reals, "max_n"]
NodeMarks = Annotated[Ints, "max_n"]
Pairs = Annotated[Reals, "max_m * max_n"]
PairMarks = Annotated[Ints, "max_m * max_n"]
ObstacleReals = Annotated[Reals, "max_m"]
ObstacleMarks = Annotated[Ints, "max_m"]
ObstacleNodes = Annotated[Grid, "max_m", "max_n"]
Parts = Annotated[Reals, 17]
Codes = Annotated[Ints, "max_certified"]
Costs = Annotated[Reals, "max_certified"]
BandNodes = Annotated[Grid, "max_bands", "max_n"]
BandPoints = Annotated[Grid, "max_bands", "2 * max_n"]
BandBoxes = Annotated[Reals, "5 * max_m * max_bands * max_n"]
BandStarts = Annotated[Grid, "max_bands", 3]
BandSides = Annotated[Ints, "max_m * max_bands"]

# status
OK = 0
INFEASIBLE = 1
NOT_CONVERGED = 2
UNEVEN_SPACING = 3
TOO_LONG = 4  # for the digits of a double, where a band begins off its route
INVALID_BOXES = 5  # not finite, or of negative size

# reason of a status
SATISFIED = 0
CLEARANCE = 1
EDGE = 2
DISPLACEMENT = 3
CURVATURE = 4
EMPTY_INTERVAL = 5
BLOCKED_END = 6
ACTIVE_SET = 7

# active constraint: the index of an obstacle, or
NO_CONSTRAINT = -1
LEFT_EDGE = -2
RIGHT_EDGE = -3
CURVATURE_LIMIT = -4

# side rule
GIVEN_SIDES = 0
BLOCKING_RIGHT = 1  # blocking obstacles are passed on the ego's right; the others keep their side
BLOCKING_LEFT = 2
CHEAPEST_SIDES = 3

# what is found for a band, in reals: clearance, edge clearance, curvature, spacing, violating value, its
# limit; x and y of each node, spline moments / 6 of each, displacement, lower and upper bound of each
REALS = 6
REALS_PER_NODE = 7
# and in integers: status, reason, active constraint, other one, node, solves
CODES = 6


class Equilibrium:
    """A band between pinned ends, one-sided bounds and the active set."""

    n: Int
    max_n: Int
    # stiffness, in units of its outermost coefficient
    rate: Real  # resists change of curvature
    bending: Real
    tension: Real
    contact: Real  # force per violation of a bound
    curvature_contact: Real
    # bounds of the displacement, and of its second difference where `bounded` says so
    lower: Nodes
    upper: Nodes
    bounded: Flag
    lower_difference: Nodes
    upper_difference: Nodes
    # active set: -1 where a lower bound is violated, 1 an upper one
    active: NodeMarks
    sharp: NodeMarks  # of the second difference
    # found
    u: Nodes
    solves: Int
    definite: Flag  # whether digits have sufficed
    # one step
    force: Nodes
    target: Nodes
    step: Nodes
    residual: Nodes
    difference: Nodes
    moment: Nodes
    # factors of the stiffness matrix
    inverse: Nodes
    factor_1: Nodes
    factor_2: Nodes
    factor_3: Nodes


class BandWork:
    """One band: its problem, its certificate, and what the rounds of tightening need."""

    n: Int
    m: Int
    n_certified: Int  # side assignments that are certified
    max_n: Int
    max_m: Int
    max_certified: Int
    # settings
    length: Real
    width: Real
    box_offset: Real
    clearance: Real
    k_s: Real
    k_b: Real
    k_c: Real
    k_e: Real
    max_displacement: Real
    max_tightenings: Int
    max_solves: Int
    max_stalls: Int
    min_progress: Real
    clearance_margin: Real
    curvature_margin: Real
    max_end_shortfall: Real
    max_free_sides: Int
    side_change_fraction: Real
    # problem
    has_edges: Flag
    has_valid_boxes: Flag
    route_x: Nodes
    route_y: Nodes
    right_edge: Nodes
    left_edge: Nodes
    curvature_limit: Nodes
    box_x: ObstacleNodes
    box_y: ObstacleNodes
    half_length: ObstacleNodes
    half_width: ObstacleNodes
    lead_distance: ObstacleReals
    passes_left: ObstacleMarks
    has_former: Flag
    former: ObstacleMarks  # sides of the previous band
    start_before: Real  # displacement a node before the first, at the first and at the second
    start_0: Real
    start_1: Real
    # route and obstacles in the frame of each node
    spacing: Real
    tangent_x: Nodes
    tangent_y: Nodes
    route_curvature: Nodes
    free: Nodes  # response to the start alone
    heading_x0: Real  # of the band at its ends
    heading_y0: Real
    heading_x1: Real
    heading_y1: Real
    moment_x0: Real  # spline moments / 6 there
    moment_y0: Real
    moment_x1: Real
    moment_y1: Real
    box_ahead_x: ObstacleNodes
    box_ahead_y: ObstacleNodes
    radius: ObstacleNodes
    max_radius: ObstacleReals
    is_fixed: ObstacleMarks  # whether its box is the same at all nodes, and kept at the first one alone
    max_step: ObstacleReals  # longest way of a corner from node to node
    overlap: ObstacleNodes  # of an obstacle and the ego along the route
    passing_right: ObstacleNodes  # displacement at which the ego passes on the right; infinite if far
    passing_left: ObstacleNodes
    # displacement and its bounds
    u: Nodes
    best_u: Nodes
    lower: Nodes
    upper: Nodes
    low: Nodes  # bounds of the next round
    high: Nodes
    lower_difference: Nodes
    upper_difference: Nodes
    # curve through the nodes
    x: Nodes
    y: Nodes
    chord: Nodes
    ahead_x: Nodes
    ahead_y: Nodes
    moment_x: Nodes
    moment_y: Nodes
    curvature: Nodes
    diagonal: Nodes
    # certificate
    center_x: Nodes  # of the ego's box
    center_y: Nodes
    near: Real  # gaps up to here may be the least
    n_pairs: Int  # of obstacles and nodes that are near each other
    right_margin: Nodes
    left_margin: Nodes
    min_gap: Real
    min_edge_clearance: Real
    max_curvature: Real
    curvature_ratio: Real
    finite: Flag
    pair_obstacle: PairMarks
    pair_node: PairMarks
    sampled: Pairs  # gaps at nodes
    bulge: Pairs
    bound: Pairs  # of the gap from a node to the next
    parts: Parts
    # result
    status: Int
    reason: Int
    active: Int
    other: Int  # second constraint of an empty interval
    node: Int
    solves: Int
    value: Real  # that violates a limit
    limit: Real
    # sides
    blocking: ObstacleMarks
    is_free: ObstacleMarks  # whether both sides are tried
    default_side: ObstacleMarks  # side of the others
    rank: ObstacleMarks  # by distance, among those of which both sides are free
    distance: ObstacleReals
    codes: Codes  # side assignments to be certified, cheapest first
    costs: Costs


class BandBatch:
    """Problems of bands of one shape."""

    n: Int
    m: Int
    bands: Int
    max_bands: Int
    max_n: Int
    max_m: Int
    side_rule: Int
    has_edges: Flag
    has_former: Flag
    nodes: BandPoints
    boxes: BandBoxes  # x, y, heading, length and width: of each, rows (obstacle, band) of max_n
    right_edge: BandNodes
    left_edge: BandNodes
    curvature_limit: BandNodes
    start: BandStarts
    lead_distance: ObstacleReals
    former: BandSides  # sides of the previous bands
    passes_left: BandSides  # given, or found
