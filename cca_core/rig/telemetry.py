"""What the vehicle computer reports to the monitor: one JSON object ten times a second."""

import json
import math
from typing import Any

from cca_core.real_time import RealTimeLoop
from cca_core.rig.vehicle import VehicleNode

_MAX_NODES = 60  # of the band


def encode_telemetry(node: VehicleNode, t: float, loop: RealTimeLoop) -> bytes:
    """Describe the last cycle of the vehicle computer.

    Parameters
    ----------
    node : VehicleNode
        The vehicle computer.
    t : float
        Control time [s].
    loop : RealTimeLoop
        Its cycle.

    Returns
    -------
    data : bytes
        JSON object with the action and its reason, ego, vehicles, band, and the health of state, radio and
        cycle; positions [m], times [us].
    """
    state, status, row = node.receiver.state, node.receiver.status, node.last
    content: dict[str, Any] = {
        "t": round(t, 3), "lost": node.receiver.is_lost(t), "counts": dict(node.counts),
        "state_counts": dict(node.receiver.counts), "cycle": loop.summary(),
    }  # fmt: skip
    if state is not None and status is not None:
        motion = state.x, state.y, state.psi, state.v_x, state.delta, state.a_x
        content["ego"] = [_rounded(value) for value in motion]
        content["kit"] = status.state.name
    if row is not None:
        decision = row.command.decision
        content |= {
            "action": decision.action.value, "reason": decision.reason, "status": row.command.status.name,
            "a_x": _rounded(row.a_x), "delta": _rounded(row.command.delta), "planner_us": round(row.cycle_us),
            "vehicles": [
                [v.id, *map(_rounded, (v.x, v.y, v.psi, v.v_x, v.length, v.width, v.age)), v.source]
                for v in row.remotes
            ],
        }  # fmt: skip
    if node.band is not None:
        step = max(math.ceil(len(node.band.nodes) / _MAX_NODES), 1)
        content["band"] = [[_rounded(x), _rounded(y)] for x, y in node.band.nodes[::step].tolist()]
    if node.health is not None:
        content["radio"] = {
            "received": node.health.received, "accepted": node.health.accepted,
            "trusted": node.health.trusted, "reason": node.health.reason,
            "clock_offset": node.health.clock_offset,
        }  # fmt: skip
    return json.dumps(content).encode("utf-8")


def _rounded(value: float) -> float:
    return round(float(value), 4)
