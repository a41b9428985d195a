"""One run of a study: sampled, and simulated with each of the three ego types."""

from dataclasses import replace
from typing import Any

from cca_core.sim.log import Log
from cca_core.sim.loop import make_controller, run_loop
from cca_core.sim.overlaps import describe_overlap
from cca_core.sim.plants.build import PlantMaker
from cca_core.sim.scenarios.scenario import EGO_TYPES, Scenario
from cca_core.sim.study.counterfactual import avoiding_action, first_hazard_cycle
from cca_core.sim.study.parameters import ParameterRanges, sample_scenario, without_v2v
from cca_core.vehicle import VehicleParams


def simulate_run(
    parameters: ParameterRanges, seed: int, index: int, plant: str | PlantMaker = "single_track"
) -> dict[str, Any]:
    """Simulate run `index` of a study with each ego type; return its samples and results as one row."""
    scenario, nominal, samples = sample_scenario(parameters, seed, index)
    log = _simulate(scenario, nominal, plant)
    hazard = first_hazard_cycle(log)
    row: dict[str, Any] = {
        **samples,
        "t_hazard": None if hazard is None else float(log.t[hazard]),  # arrival of the warning [s]
        "avoiding_action": avoiding_action(log, plant),
    }
    for ego_type in EGO_TYPES:
        if ego_type != "v2v":
            log = _simulate(without_v2v(scenario, ego_type), nominal, plant)
        row |= {
            f"{ego_type}_collided_with": log.collided_with,  # empty if there was no collision
            f"{ego_type}_speed": log.closing_speed() if log.collided_with else 0.0,  # [m/s]
            f"{ego_type}_gap": float(log.gaps().min()) if scenario.road_users else None,  # [m]
            f"{ego_type}_deceleration": max(0.0, -float(log.ego[:, 7].min())),  # [m/s^2]
            f"{ego_type}_last_decision": f"{log.decisions[-1][1]}: {log.cycle_reasons[-1]}",
            # empty if no road user drives into another
            f"{ego_type}_overlap": describe_overlap(log.overlaps[0]) if log.overlaps else "",
        }
    return row


def _simulate(scenario: Scenario, nominal: VehicleParams, plant: str | PlantMaker) -> Log:
    controller = make_controller(replace(scenario, vehicle=nominal))
    return run_loop(scenario, plant=plant, planner=controller)
