"""Small cases in which the library once fell short, each with the right outcome.

They use public results only: commands in a closed loop, tracks, paths, files. Speeds are in m/s,
distances in m, accelerations in m/s^2.
"""

from tests.trials.faults import commonroad, controls, files, messages, paths, road, routes, traffic
from tests.trials.faults.table import Table

TABLE = Table(
    routes.TABLE,
    messages.TABLE,
    traffic.TABLE,
    road.TABLE,
    paths.TABLE,
    files.TABLE,
    messages.WRAPPERS,
    commonroad.TABLE,
    controls.TABLE,
)
