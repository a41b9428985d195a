"""The text of every public record fits a line, or five."""

import dataclasses
import importlib
import inspect
import pkgutil
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

import cca_core
from cca_core import EvasionSettings, RemoteVehicle, VehicleParams
from cca_core._repr import short_repr
from cca_core.decide import Rejection, RejectionKind
from cca_core.sim import ParameterRanges, Study, eebl, ima
from cca_core.v2x import Tracker
from tests.support.recorded_data import ROUTE, examples

MAX_LINES = 5
MAX_LENGTH = 440  # characters; four lines


def built_from_nothing() -> Iterator[Any]:
    """One of each public dataclass that needs no arguments."""
    for module in pkgutil.iter_modules(cca_core.__path__, "cca_core."):
        package = importlib.import_module(module.name)
        for name in getattr(package, "__all__", []):
            value = getattr(package, name)
            if not inspect.isclass(value) or not dataclasses.is_dataclass(value):
                continue
            if all(f.default is not f.default_factory or not f.init for f in dataclasses.fields(value)):
                yield value()


def records() -> dict[str, Any]:
    """Public records by class name."""
    study = Study(parameters=ParameterRanges(scenario="eebl"), runs=8)
    given = [eebl("C"), ima(), eebl("C").road_users[0], study, study.parameters]
    found = {type(value).__name__: value for value in [*built_from_nothing(), *given]}
    return {**found, **examples()}


RECORDS = records()


@pytest.mark.parametrize("name", sorted(RECORDS))
def test_repr_is_short(name: str) -> None:
    text = repr(RECORDS[name])
    assert text.startswith(name)
    assert len(text) <= MAX_LENGTH
    assert text.count("\n") < MAX_LINES
    assert " at 0x" not in text


def test_repr_shows_what_differs_from_the_defaults() -> None:
    assert repr(EvasionSettings()) == "EvasionSettings()"
    assert repr(EvasionSettings(clearance=0.6)) == "EvasionSettings(clearance=0.6)"
    assert repr(RemoteVehicle(id="a", x=1.0, y=2.0, psi=0.0, v_x=1 / 3)) == (
        "RemoteVehicle(id='a', x=1, y=2, psi=0, v_x=0.333333)"
    )


def test_repr_leaves_out_unknown_numbers() -> None:
    rejection = Rejection(kind=RejectionKind.NO_LANE, side="left")
    assert repr(rejection) == "Rejection(kind=RejectionKind.NO_LANE, side='left')"


@dataclasses.dataclass
class Held:
    """A record with one field."""

    value: Any

    __repr__ = short_repr


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (np.zeros((400, 2)), "array of 400 x 2"),
        (np.arange(100.0), "ndarray of 100 from 0 to 99"),
        (np.array([0.5, 1.0]), "[0.5, 1]"),
        (np.array(3.0), "3"),
        (np.array([]), "[]"),
        (np.array(["a"] * 9), "ndarray of 9"),
        ((1.0,), "(1,)"),
        (("a" * 60, "b" * 60), "tuple of 2"),
        (frozenset({"a"}), "{'a'}"),
        ({"a": 1}, "dict of 1"),
        ("x" * 300, f"'{'x' * 75}...'"),
        (eebl, "eebl"),
        (VehicleParams.bmw_320i(), "VehicleParams(...)"),
    ],
)
def test_values_are_shortened(value: Any, text: str) -> None:
    assert repr(Held(value)) == f"Held(value={text})"


def test_objects_with_a_state_show_it() -> None:
    assert repr(Tracker(cca_core.LocalFrame(41.3, -105.6))) == "Tracker(0 tracks, 0 messages)"
    assert repr(ROUTE).startswith("Path(")
