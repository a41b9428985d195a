"""A route over several edges: crossing traffic, a lane that ends, limits that change, and a turn."""

import random
from pathlib import Path

from tests.trials.sumo.nets import MODELS, convert

CRUISE_SPEED = 30.0  # above the limits [m/s]
ROUTE = "in on drop town out"
FINISH = 250.0  # before the end of the route, where the ego would begin to stop [m]
NODES = {
    "A": (0, 0), "B": (800, 0), "C": (1500, 0), "D": (2000, 40), "E": (2400, 40), "F": (2400, -900),
    "N": (800, 300), "S": (800, -300), "G": (2800, 40),
}  # fmt: skip
EDGES = (  # id, from, to, number of lanes, speed limit [m/s], priority
    ("in", "A", "B", 2, 25.0, 3), ("on", "B", "C", 2, 25.0, 3), ("drop", "C", "D", 1, 22.0, 3),
    ("town", "D", "E", 1, 14.0, 3), ("out", "E", "F", 1, 22.0, 3), ("east", "E", "G", 1, 14.0, 3),
    ("north", "N", "B", 1, 14.0, 1), ("south", "B", "S", 1, 14.0, 1),
    ("up", "S", "B", 1, 14.0, 1), ("away", "B", "N", 1, 14.0, 1),
)  # fmt: skip


def write_network(folder: Path) -> Path:
    """Write the net."""
    nodes = "".join(f'<node id="{name}" x="{x}" y="{y}"/>' for name, (x, y) in NODES.items())
    edges = "".join(
        f'<edge id="{name}" from="{a}" to="{b}" numLanes="{n}" speed="{v}" priority="{p}" width="3.5"/>'
        for name, a, b, n, v, p in EDGES
    )
    return convert(folder, "network", nodes, edges, "--default.junctions.radius", "15")


def write_network_traffic(seed: int, folder: Path, ego: str) -> Path:
    """Write the traffic of a seed; `ego` holds the attributes of the ego's size."""
    rng, model = random.Random(seed), MODELS[seed % len(MODELS)]
    kinds = {
        "car": 'length="4.5" width="1.8" maxSpeed="50" speedFactor="normc(0.98,0.12,0.7,1.25)"',
        "truck": 'length="12" width="2.5" maxSpeed="19" accel="1.0"',
        "ego": f'{ego} maxSpeed="{CRUISE_SPEED}" accel="2.0"',
    }
    out = [f'<vType id="{k}" decel="4.5" carFollowModel="{model}" {v}/>' for k, v in kinds.items()]
    routes = {"main": ROUTE, "east": "in on drop town east", "down": "north south", "away": "up away"}
    out += [f'<route id="{name}" edges="{edges}"/>' for name, edges in routes.items()]
    period = rng.uniform(7.0, 14.0)  # between vehicles on the ego's route [s]
    flows = (("car", "main", period), ("car", "east", 2.0 * period), ("truck", "main", 3.0 * period))
    for kind, route, gap in flows:
        out.append(
            f'<flow id="{kind}_{route}" type="{kind}" route="{route}" begin="0" end="400" '
            f'departLane="best" departSpeed="max" period="exp({1.0 / gap:.4f})"/>'
        )
    for route in ("down", "away"):
        out.append(
            f'<flow id="{route}" type="car" route="{route}" begin="0" end="400" departSpeed="max" '
            f'period="exp({1.0 / rng.uniform(8.0, 20.0):.4f})"/>'
        )
    lane = rng.randrange(2)
    out.append(
        f'<vehicle id="ego" type="ego" route="main" depart="30" departLane="{lane}" departPos="20" '
        'departSpeed="20"/>'
    )
    # SUMO wants vehicles by time of departure: flows begin at 0
    file = folder / f"network_{seed}.rou.xml"
    file.write_text(f"<routes>{''.join(out)}</routes>")
    return file
