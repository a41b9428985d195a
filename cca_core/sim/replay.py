"""Replay of a log: the controller on the recorded messages and detections."""

from dataclasses import replace

import numpy as np

from cca_core._checks import Array
from cca_core.sim.log import Log
from cca_core.sim.loop import EgoController, make_controller
from cca_core.sim.world.perception import Perception
from cca_core.vehicle import VehicleState


def replay(log: Log, *, planner: EgoController | None = None) -> Array:
    """Run the ego's controller on the recorded inputs and ego motion.

    Parameters
    ----------
    log : Log
        The run, fresh or loaded. The inputs are the messages and the visibility of a simulated run, and the
        remote vehicles and the awareness range of a recorded one.
    planner : EgoController, optional
        Another controller; the default is made from the scenario.

    Returns
    -------
    command : ndarray, shape (n, 2)
        Road-wheel angle [rad] and acceleration [m/s^2]. With the default controller these are the log's
        commands, bit for bit, if the run used the default too. A recorded run did so if its planner was made
        with nothing but the values that `Recorder` reads, and given neither `radio` nor `VehicleState.t`.
    """
    scenario, is_recorded = log.scenario, log.remotes is not None
    if is_recorded and scenario.ego_type == "sensor":  # its own loop stated the awareness range
        scenario = replace(scenario, ego_type="v2v")
    controller = planner or make_controller(scenario)
    perception = Perception(scenario)
    messages: list[list[bytes]] = [[] for _ in log.t]
    for row, data in log.received:
        messages[row].append(data)
    rows = np.concatenate((log.road_users, log.user_motion), axis=2).tolist()
    command = np.empty((len(log.t), 2))
    for k, (t, ego) in enumerate(zip(log.t.tolist(), log.ego.tolist(), strict=True)):
        x, y, psi, v_x, v_y, r, delta, a_x = ego
        state = VehicleState(x=x, y=y, psi=psi, v_x=v_x, v_y=v_y, r=r, delta=delta, a_x=a_x)
        if log.remotes is None or log.awareness_range is None:
            remotes = perception.remotes(t, rows[k], log.visible[k].tolist(), messages[k], state)
            known = perception.awareness_range(t)
        else:
            remotes, known = list(log.remotes[k]), float(log.awareness_range[k])
        replayed = controller.step(t, state, remotes, awareness_range=known)
        command[k] = replayed.delta, replayed.a_x
    return command
