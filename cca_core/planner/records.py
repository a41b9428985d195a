"""Records of the planner: what is seen, what can be driven, what it is worth, and the planner's state."""

import math
from dataclasses import dataclass, field
from enum import Enum, IntEnum
from typing import NamedTuple

import numpy as np

from cca_core._checks import Array
from cca_core.band import Band, Side
from cca_core.decide import Rejection, RejectionKind
from cca_core.frenet import FrenetVehicle
from cca_core.path import Lane, Path
from cca_core.planner.assumptions import Assumptions
from cca_core.planner.certificate import Certificate, Grade, SafeStop
from cca_core.planner.last_known import Memory
from cca_core.vehicle import VehicleState

_OFF_ROUTE = 0.3  # offset from which the ego is off its route [m]


class PathKind(Enum):
    """What a candidate path is for."""

    ROUTE = "route"
    RETURN = "return"
    LEFT = "left"
    RIGHT = "right"

    @property
    def is_evasive(self) -> bool:
        """Whether it passes vehicles."""
        return self in (PathKind.LEFT, PathKind.RIGHT)


class Level(IntEnum):
    """How a path uses tires and space; the lower, the more comfortable."""

    COMFORT = 0
    HARD = 1
    NARROW = 2


class Profile(NamedTuple):
    """How fast a path is driven."""

    name: str
    follows: bool = True
    passes: bool = False  # follows only beyond the deformed part of the path
    yields: int = 0
    braking: float = 0.0
    kept: bool = False


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class LateralPath:
    """A candidate path: lateral offset at stations a meter apart, and what it is for."""

    kind: PathKind
    base: int  # station of the first value of `d` [m]
    d: Array
    begin: float = -math.inf  # stations between which it leaves the route [m]
    end: float = -math.inf
    level: Level = Level.COMFORT
    overtaken: frozenset[str] = frozenset()
    clearance: float = 0.0
    band: Band | None = None
    reference: Path | None = None
    is_last: bool = False
    gap: float = math.inf  # least gap to the others when it was chosen [m]
    a_y: float = math.inf  # lateral acceleration up to which the ego speeds up on it [m/s^2]
    rest: float = 0.0  # lateral offset beyond the last station [m]
    to_lane: Lane | None = None  # in which it ends, if that is not the ego lane
    is_smooth: bool = False  # it begins where steering does not look yet
    change: str = ""  # side of the lane change that it belongs to

    @property
    def side(self) -> str:
        """Side on which vehicles are passed."""
        return self.kind.value

    @property
    def start(self) -> float:
        """Station at which it leaves the route [m]."""
        return self.begin

    @property
    def stations(self) -> Array:
        """Stations of `d` [m]."""
        return self.base + np.arange(float(len(self.d)))

    def offset_at(self, s: float) -> float:
        """Return the lateral offset at a station [m], 0 before the first one."""
        return float(np.interp(s, self.stations, self.d, left=0.0, right=self.rest))

    def has_begun(self, s: float) -> bool:
        """Return whether it, or a maneuver that it goes on from, is off the route at a station."""
        return self.begin <= s or abs(self.offset_at(s)) > _OFF_ROUTE

    def on(self, base: int, n: int) -> Array:
        """Return the lateral offset on another stretch of the route; 0 before the first station."""
        d, shift = np.zeros(n), base - self.base
        begin, end = max(-shift, 0), min(len(self.d) - shift, n)
        if end > begin:
            d[begin:end] = self.d[begin + shift : end + shift]
        if self.rest != 0.0:
            d[max(end, 0) :] = self.rest
        return d


class LaneWish(NamedTuple):
    """A lane next to the ego lane that is to become the ego lane."""

    side: Side
    lane: Lane
    d: float  # of the route in it [m]
    waited: float  # time since it is wished for [s]


class Waiting(NamedTuple):
    """For which lane the ego waits, and why it is not clear."""

    side: Side
    rejection: Rejection | None

    def __str__(self) -> str:
        return f"waiting for the {self.side} lane"

    @property
    def cause(self) -> str:
        """Vehicle with its distance, or the rejection."""
        rejection = self.rejection
        if rejection is None:
            return "no comfortable change is certified"
        if rejection.kind is RejectionKind.NO_LANE:
            return "it is not there yet"
        return rejection.why


class Costs(NamedTuple):
    """Terms of the cost of a plan [s]."""

    progress: float = 0.0
    speed: float = 0.0
    comfort: float = 0.0
    lateral: float = 0.0
    outside: float = 0.0
    change: float = 0.0
    safe_end: float = 0.0
    risk: float = 0.0


class Branch(NamedTuple):
    """How a plan ends safely: driven for a time on a path, then braked."""

    path: LateralPath
    path_row: int
    react: float  # [s]
    braking: float  # [m/s^2]; 0 if the plan goes on
    is_other: bool = False  # another path than the plan's, with its speeds


@dataclass(slots=True, kw_only=True, eq=False)
class Plan:
    """A candidate: a path, a profile, the motion that follows, and its certificate."""

    path: LateralPath
    row: int  # of the motion and of the path in the scene
    path_row: int
    profile: Profile
    s: Array  # relative to the first station of the scene [m]
    v: Array
    a: Array
    d: Array
    branch: Branch  # its safe end
    limited_by: int = -1
    peak: float = 0.0  # lateral acceleration [m/s^2]
    costs: Costs = field(default_factory=Costs)
    grade: Grade = Grade.SEVERITY
    braking: float = math.inf  # deceleration that its safe end needs [m/s^2]
    silence: float = 0.0  # of that vehicle, as a part of the time that asks for full braking [-]
    decides: str = ""  # vehicle to which the certificate leaves least, or that prevents it
    gap: float = math.inf  # least nominal gap [m]
    severity: float = 0.0
    is_prolonged: bool = False  # it has no new certificate, but the last one is still valid
    exposure: float = 0.0  # impact speed in the worst case, with full braking after the reaction time [m/s]
    at_stake: float = 0.0  # squared impact speed without it, less if it comes later [m^2/s^2]
    peril: float = 0.0  # what both cost, when all plans come too close [s]
    patience: float = 1.0  # part of time and comfort that counts, less if an impact is near [-]
    impact_id: str = ""
    rejection: Rejection | None = None
    is_certified: bool = False

    @property
    def cost(self) -> float:
        """Sum of the terms [s]."""
        return sum(self.costs)


class Mode(Enum):
    """What the ego does; a label of the plan that it drives."""

    KEEP = "KEEP"
    FOLLOW = "FOLLOW"
    EVADE_LEFT = "EVADE_LEFT"
    EVADE_RIGHT = "EVADE_RIGHT"
    RETURN = "RETURN"
    BRAKE = "BRAKE"
    SAFE_STOP = "SAFE_STOP"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class DrivenPlan:
    """The plan that is being driven, from the time of its decision on."""

    t: float
    path: LateralPath
    reference: Path
    profile: Profile
    s: Array  # stations at `scene.TIMES` [m]
    v: Array
    a: Array
    a_0: float
    certificate: Certificate
    limited_by: str  # id of a vehicle, "curve" or ""
    yields_to: str
    free_a: float  # acceleration without other vehicles [m/s^2]
    safe_stop: SafeStop
    rejections: tuple[Rejection, ...] = ()
    costs: Costs = field(default_factory=Costs)
    impact_id: str = ""
    assumptions: Assumptions | None = None  # of the certificate; None if the worst case is not excluded
    waiting: Waiting | None = None  # for another lane

    @property
    def grade(self) -> Grade:
        """What it is certified against."""
        return self.certificate.grade


class PlannerState(NamedTuple):
    """All that the planner remembers from cycle to cycle."""

    s: float | None = None
    v: float = 0.0
    mode: Mode = Mode.KEEP
    wish: Mode = Mode.KEEP
    t_wish: float = -math.inf  # since when another mode is wished for [s]
    plan: DrivenPlan | None = None
    t_decided: float = -math.inf
    a_x: float = 0.0  # commanded
    a_true: float = 0.0  # after the lag of the brakes
    delta: float = 0.0
    seen: frozenset[tuple[str, frozenset[str]]] = frozenset()
    has_news: bool = True  # whether a vehicle or an event was new at the last decision
    estimate: VehicleState | None = None  # last known or dead-reckoned
    memory: Memory = Memory()  # of other vehicles


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Observation:
    """What is seen in a cycle: the ego on its route, and the other vehicles."""

    t: float
    s: float  # of the center of gravity
    d: float
    angle: float  # of the heading to the route [rad]
    bend: float  # curvature beyond that of the route [1/m]
    v: float
    vehicles: tuple[FrenetVehicle, ...]
    awareness_range: float
    memory: Memory = field(default_factory=Memory)
