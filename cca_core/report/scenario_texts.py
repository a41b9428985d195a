"""What happens in each built-in scenario, in words."""

from cca_core.sim import Scenario

_SITUATIONS = {
    "eebl": "Three cars drive in one lane. Red, the first one, brakes hard. Yellow hides it from the ego,"
    " which follows yellow too closely.",
    ("ima", "left-turn"): "The ego turns left across the lane of oncoming red. A waiting truck hides red.",
    (
        "ima",
        "crossing",
    ): "The ego drives straight on across an intersection. A building hides red, which comes from the right.",
    "curbside": "Red is parked partly in the ego's lane. Yellow drives ahead of the ego, hides red, and moves"
    " aside late.",
    ("maneuver", "1-fast"): "R1 and R3 are slow in the ego's lane, and R2 is slow in the left lane, between"
    " them. The ego is tuned for a fast response.",
    ("maneuver", "1-smooth"): "R1 and R3 are slow in the ego's lane, and R2 is slow in the left lane, between"
    " them. The ego is tuned for comfort.",
    ("maneuver", "2"): "R1 and R2 are slow in the ego's lane. A comes from behind in the left lane and is"
    " faster than the ego.",
    ("maneuver", "3"): "R1 and R2 are slow in the ego's lane. A comes toward the ego in the left lane.",
}

PAPER = (
    "S. Y. Gelbal, S. Zhu, G. A. Anantharaman, B. Aksun Guvenc, L. Guvenc: Cooperative Collision Avoidance in"
    " a Connected Vehicle Environment"
)
"""The paper whose scenarios are simulated."""


def describe_situation(scenario: Scenario) -> str:
    """Describe what happens in a scenario; empty if it is not a built-in one."""
    case = scenario.name, scenario.case or ""
    return _SITUATIONS.get(case, _SITUATIONS.get(scenario.name, ""))


def paper_figures(scenario: Scenario) -> str:
    """Figures of the paper that show a scenario, such as ``"Figs 5 to 7"``."""
    numbers = scenario.paper_figures
    if not numbers:
        return ""
    if len(numbers) == 1:
        return f"Fig {numbers[0]}"
    return f"Figs {numbers[0]} {'to' if len(numbers) > 2 else 'and'} {numbers[-1]}"
