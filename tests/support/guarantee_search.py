"""Adversarial search: hill climbing over a situation for the smallest gap to a certified plan."""

from dataclasses import replace
from typing import Any

import numpy as np

from cca_core.planner import EvasionSettings
from tests.support.declared_motion import min_gap
from tests.support.guarantee import Case, Sender, decide, sample_case

_SENDER = {
    "s": (6.0, -1e4, 1e4), "d": (0.25, -8.0, 8.0), "v": (2.0, -38.0, 38.0), "v_d": (0.3, -1.2, 1.2),
    "a": (1.5, -8.0, 3.0), "age": (0.2, 0.0, 0.95), "along": (0.5, -1.0, 1.0), "across": (0.5, -1.0, 1.0),
    "first": (0.7, -1.0, 1.0), "second": (0.7, -1.0, 1.0), "switch": (1.0, 0.0, 10.0),
}  # fmt: skip
_EGO = {
    "v": (1.5, 0.0, 36.0), "cruise": (2.0, 1.0, 36.0), "driven": (0.5, 0.0, 6.0), "sigma": (0.1, 0.0, 0.5),
}  # fmt: skip
"""Scale of a change, and bounds."""


def search(
    seed: tuple[int, int], settings: EvasionSettings, steps: int, *, reacts: bool
) -> tuple[float, Case]:
    """Return the smallest gap to a certified plan found in some decisions [m], and the situation."""
    rng = np.random.default_rng(seed)
    best, gap = _start(rng, settings, reacts=reacts)
    for _ in range(steps):
        if gap < 0.0:
            break
        case = _changed(rng, best)
        found = _gap(case, settings, reacts=reacts)
        if found is not None and found <= gap:
            best, gap = case, found
    return gap, best


def _start(rng: np.random.Generator, settings: EvasionSettings, *, reacts: bool) -> tuple[Case, float]:
    """Return a certified situation with a vehicle near the ego."""
    while True:
        case = sample_case(rng)
        gap = _gap(case, settings, reacts=reacts)
        if gap is not None and gap < 4.0:
            return case, gap


def _gap(case: Case, settings: EvasionSettings, *, reacts: bool) -> float | None:
    """Return the gap to a certified plan; None if it is not certified."""
    decided = decide(case, settings)
    certificate = decided.command.certificate
    if certificate is None or not certificate.keeps_worst_case:
        return None
    return min_gap(decided, np.random.default_rng(1), reacts=reacts)


def _changed(rng: np.random.Generator, case: Case) -> Case:
    """Change some numbers of a situation."""
    ego = {name: _moved(rng, getattr(case, name), *_EGO[name]) for name in _EGO if rng.random() < 0.2}
    if not case.driven:
        ego.pop("driven", None)
    senders = tuple(_changed_sender(rng, sender) for sender in case.senders)
    if len(senders) > 1 and rng.random() < 0.1:
        senders = senders[:-1]
    return replace(case, senders=senders, **ego)


def _changed_sender(rng: np.random.Generator, sender: Sender) -> Sender:
    if rng.random() < 0.4:
        return sender
    changes: dict[str, Any] = {
        name: _moved(rng, getattr(sender, name), *_SENDER[name]) for name in _SENDER if rng.random() < 0.3
    }
    if sender.v * changes.get("v", sender.v) < 0.0:
        changes.pop("v")
    return replace(sender, **changes)


def _moved(rng: np.random.Generator, value: float, scale: float, low: float, high: float) -> float:
    """Return a number changed a little, sometimes to an end of its range."""
    return float(np.clip(value + scale * rng.standard_normal() * rng.choice((0.2, 1.0)), low, high))
