"""One run of a study: drawn, driven by three egos, judged."""

from typing import Any

from cca_core.sim.log import Log
from cca_core.sim.loop import make_driver, make_planner, simulate
from cca_core.sim.scenarios.scenario import EGO_TYPES, Scenario
from cca_core.sim.study.counterfactual import avoiding_action, first_hazard_cycle
from cca_core.sim.study.parameters import ParameterRanges, nominal_scenario, sample_scenario, without_v2v

__all__ = ["simulate_run"]


def simulate_run(
    variation: ParameterRanges, seed: int, index: int, plant: str = "single_track"
) -> dict[str, Any]:
    """Drive one run with each of the three egos.

    Parameters
    ----------
    variation : Variation
        What is drawn.
    seed, index : int
        The study's seed, and the number of the run in it, from 0.
    plant : {"single_track", "multi_body"}
        The ego's car.

    Returns
    -------
    row : dict
        What was drawn; ``"t_hazard"`` [s], when the ego was first told of the hazard (None: never);
        ``"avoiding_action"``; and for each ego whom it ``hit`` (empty: nobody), at which closing ``speed`` [m/s],
        the least ``gap`` [m], the highest ``deceleration`` [m/s^2], and the last action with its reason.
    """
    scenario, drawn = sample_scenario(variation, seed, index)
    row: dict[str, Any] = {**drawn}
    log = _drive(scenario, plant)
    hazard = first_hazard_cycle(log)
    row["t_hazard"] = None if hazard is None else float(log.t[hazard])
    row["avoiding_action"] = avoiding_action(log)
    for ego in EGO_TYPES:
        if ego != "v2v":
            log = _drive(without_v2v(scenario, ego), plant)
        row[f"{ego}_collided_with"] = log.collided_with
        row[f"{ego}_speed"] = log.closing_speed() if log.collided_with else 0.0
        row[f"{ego}_gap"] = float(log.gaps().min())
        row[f"{ego}_deceleration"] = max(0.0, -float(log.ego[:, 7].min()))
        row[f"{ego}_last_decision"] = ": ".join(log.decisions[-1][1:])
    return row


def _drive(scenario: Scenario, plant: str) -> Log:
    believed = nominal_scenario(scenario)
    pilot = make_driver(believed) if scenario.ego_type == "driver" else make_planner(believed)
    return simulate(scenario, plant=plant, planner=pilot)
