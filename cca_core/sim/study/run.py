"""One run of a study: drawn, driven by three egos, judged."""

from typing import Any

from cca_core.sim.log import Log
from cca_core.sim.loop import make_driver, make_planner, simulate
from cca_core.sim.scenarios.scenario import EGOS, Scenario
from cca_core.sim.study.counterfactual import avoided_by, first_hazard
from cca_core.sim.study.parameters import Variation, draw_scenario, nominal, without_messages

__all__ = ["drive_run"]


def drive_run(variation: Variation, seed: int, index: int, plant: str = "single_track") -> dict[str, Any]:
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
        ``"avoided_by"``; and for each ego whom it ``hit`` (empty: nobody), at which closing ``speed`` [m/s],
        the least ``gap`` [m], the highest ``deceleration`` [m/s^2], and the last action with its reason.
    """
    scenario, drawn = draw_scenario(variation, seed, index)
    row: dict[str, Any] = {**drawn}
    log = _drive(scenario, plant)
    hazard = first_hazard(log)
    row["t_hazard"] = None if hazard is None else float(log.t[hazard])
    row["avoided_by"] = avoided_by(log)
    for ego in EGOS:
        if ego != "v2v":
            log = _drive(without_messages(scenario, ego), plant)
        hit = next((who for _, what, who in log.events if what == "contact"), "")
        row[f"{ego}_hit"] = hit
        row[f"{ego}_speed"] = log.closing_speed() if hit else 0.0
        row[f"{ego}_gap"] = float(log.gaps().min())
        row[f"{ego}_deceleration"] = max(0.0, -float(log.ego[:, 7].min()))
        row[f"{ego}_last"] = ": ".join(log.decisions[-1][1:])
    return row


def _drive(scenario: Scenario, plant: str) -> Log:
    believed = nominal(scenario)
    pilot = make_driver(believed) if scenario.ego == "driver" else make_planner(believed)
    return simulate(scenario, plant=plant, planner=pilot)
