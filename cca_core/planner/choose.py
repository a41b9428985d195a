"""Choice: the cost of plans, and the best of those with the best grade."""

from collections.abc import Sequence

from cca_core._checks import Array
from cca_core.planner.certificate import Grade
from cca_core.planner.certify import Certifier
from cca_core.planner.paths import Surroundings
from cca_core.planner.records import Costs, LateralPath, Level, PathKind, Plan

_TERMS = {
    "a_x": 0,
    "a_y": 1,
    "outside": 3,
    "jerk": 4,
    "s": 5,
    "v": 6,
    "d_end": 7,
    "risk": 8,
}  # columns of the scene's terms


def assess(
    plan: Plan,
    terms: Array,
    free: Array,
    around: Surroundings,
    last: LateralPath | None,
    a_0: float,
    cruise: float,
) -> None:
    """Set the cost of a plan, but for its safe end."""
    weights = around.settings.cost
    row = terms[plan.row]
    v_ref = max(cruise, 3.0)
    lost = max(free[_TERMS["s"]] - row[_TERMS["s"]], 0.0) / v_ref
    slow = max(free[_TERMS["v"]] - row[_TERMS["v"]], 0.0) / v_ref
    path, was = plan.path, PathKind.ROUTE if last is None else last.kind
    change = 0.0
    if path.kind is not was and not (was is PathKind.ROUTE and path.kind is PathKind.RETURN):
        change = weights.abort if path.kind is PathKind.RETURN else weights.change
    elif not path.is_last and path.kind is not PathKind.ROUTE and was is not PathKind.ROUTE:
        change = weights.replan
    if path.kind is PathKind.RETURN:
        change += weights.delay * max(path.end - around.s, 0.0) / max(around.v, 2.0)
    canceled = last is not None and last.to_lane is not None and path.kind is PathKind.RETURN
    if canceled and not path.is_smooth:
        change += weights.hard
    if path.level is Level.HARD and not path.is_last:
        change += weights.hard
    if path.level is Level.NARROW and not path.is_last:
        change += weights.narrow
    if path.kind.is_evasive and not path.is_last:
        aim = around.limits.a_y if path.level is Level.COMFORT else around.limits.a_y_hard
        sharp = plan.peak / aim - weights.sharp_from
        change += weights.sharp * max(sharp, 0.0) ** 2
    wish = around.wish
    wished = wish is not None and path.to_lane is not None and path.rest == wish.d
    lane, half = (path.to_lane if wished else None) or around.lane, 0.5 * around.vehicle.width
    end = row[_TERMS["d_end"]]
    arrives = lane.right < end - half < end + half < lane.left
    if not arrives:
        change += weights.astray
    if not (wished and arrives) and (wish is not None or path.to_lane is not None):
        change += weights.lane
    if path.to_lane is None and path.side == around.settings.traffic_side and row[_TERMS["outside"]] > 0.0:
        change += weights.right
    plan.costs = Costs(
        progress=weights.progress * lost, speed=weights.speed * slow,
        comfort=weights.a_x * row[_TERMS["a_x"]]
        + weights.jerk * row[_TERMS["jerk"]]
        + weights.change_of_acceleration * float(plan.a[1] - a_0) ** 2 + 0.01 * plan.profile.braking,
        lateral=weights.a_y * row[_TERMS["a_y"]], outside=weights.outside * row[_TERMS["outside"]],
        change=change, risk=weights.risk * row[_TERMS["risk"]],
    )  # fmt: skip


def choose(plans: Sequence[Plan], certifier: Certifier, around: Surroundings) -> Plan:
    """Return the cheapest plan of the best grade; plans are certified in the order of their cost."""
    best = plans[0]
    settings, limits = around.settings, around.limits
    soft = settings.certificate.comfortable_braking
    for plan in sorted(plans, key=lambda p: p.cost):
        if best.is_certified and best.grade <= Grade.RESPONSE and plan.cost >= best.cost:
            break
        if not plan.is_certified:
            certifier.certify(plan)
        if plan.grade <= Grade.RESPONSE and plan.braking > soft:
            excess = (plan.braking - soft) / max(limits.b_max - soft, 0.1)
            weight = settings.cost.safe_end + settings.cost.silence * plan.silence
            plan.costs = plan.costs._replace(safe_end=weight * excess * excess)
        elif plan.grade is Grade.NOMINAL:
            plan.costs = plan.costs._replace(safe_end=settings.cost.exposure * plan.exposure)
        elif plan.grade is Grade.SEVERITY:
            plan.peril = settings.cost.severity * plan.severity + settings.cost.at_stake * plan.at_stake
        if _goes_on(plan, around):
            lane = settings.cost.lane if plan.path.to_lane is not None else 0.0  # no reason to go on
            plan.costs = plan.costs._replace(safe_end=settings.cost.uncertified + lane)
        if not best.is_certified or _key(plan, around) < _key(best, around):
            best = plan
    return best


def _key(plan: Plan, around: Surroundings) -> tuple[float, float]:
    """Rank of a plan; a maneuver that is under way and nominally safe is compared with certified plans.

    The nearer an impact that cannot be avoided, the less time and comfort count.
    """
    tier = Grade.RESPONSE.tier if _goes_on(plan, around) else plan.grade.tier
    costs = plan.costs
    saved = (1.0 - plan.patience) * (costs.progress + costs.speed + costs.comfort)
    return tier, plan.peril + plan.cost - saved


def _goes_on(plan: Plan, around: Surroundings) -> bool:
    """Whether a plan goes on with a maneuver that begins within the time in which paths do not change."""
    path, committed = plan.path, around.settings.replan.committed_time * around.v
    begins = path.is_last and path.kind.is_evasive and path.begin <= around.s + committed
    return begins and plan.grade is Grade.NOMINAL
