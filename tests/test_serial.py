"""Settings and results survive JSON exactly; errors name the field."""

import dataclasses
import json
import math
from contextlib import suppress
from pathlib import Path as FilePath
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cca_core import Band, InputError, Lane, Path, RemoteVehicle, Road, Status, VehicleParams, relax_band
from cca_core.band import BandStiffness
from cca_core.decide import Decision
from cca_core.planner.settings import EvasionSettings
from cca_core.serial import from_dict, to_dict
from cca_core.serial.version_1 import CLASSES, FIELDS
from cca_core.sim import Scenario, overtaking
from cca_core.v2x import ChannelSettings, TrackerSettings
from tests.support.recorded_data import CAR, ROUTE, examples, parts, public_records

EXAMPLES = examples()
VERSION_1 = json.loads((FilePath(__file__).parent / "support" / "records_1.json").read_text())
KINDS = {CLASSES.get(name, name): type(value) for name, value in EXAMPLES.items()} | {"Scenario": Scenario}


def round_trip(value: Any) -> Any:
    return from_dict(type(value), json.loads(json.dumps(to_dict(value), allow_nan=False)))


def test_every_public_record_has_example() -> None:
    assert {kind.__name__ for kind in public_records()} - EXAMPLES.keys() == set()


@pytest.mark.parametrize("name", sorted(EXAMPLES))
def test_round_trip_preserves_record(name: str) -> None:
    value = EXAMPLES[name]
    again = round_trip(value)
    assert type(again) is type(value)
    assert parts(again) == parts(value)
    assert to_dict(again) == to_dict(value)


def assert_kept(old: Any, new: Any) -> None:
    """Assert that every value of version 1 is in the description of today, which may hold more."""
    if isinstance(old, dict) and "type" in old:
        if new["type"] == "BandProblem":  # described by its arguments since
            old = {name: old[name] for name in ("vehicle", "clearance", "curvature_limit", "stiffness")}
        names = FIELDS.get(new["type"], {})
        for key in old.keys() - {"type", "version"}:
            assert_kept(old[key], new[names.get(key, key)])
    elif isinstance(old, list):
        assert len(old) == len(new)
        for value, again in zip(old, new, strict=True):
            assert_kept(value, again)
    else:
        assert new == {"'FALLBACK'": "DEGRADED", "'ahead'": "direct"}.get(repr(old), old)


@pytest.mark.parametrize("data", VERSION_1, ids=[data["type"] for data in VERSION_1])
def test_version_1_is_read_with_equal_values(data: dict[str, Any]) -> None:
    assert data["version"] == 1
    assert_kept(data, to_dict(from_dict(KINDS[data["type"]], data)))


def test_band_of_version_1_is_the_same_band() -> None:
    (data,) = (data for data in VERSION_1 if data["type"] == "Band")
    band = from_dict(Band, data)
    problem = band.problem
    again = relax_band(
        problem.nodes[0], vehicle=problem.vehicle, stiffness=problem.stiffness,
        corridor=tuple(problem.edges[:, 0]),
    )  # fmt: skip
    assert problem.start.tolist() == [[0.0, 0.0, 0.0]]
    assert problem.boxes.shape == (5, 0, 1, len(band))
    assert (again.nodes.tolist(), again.edge_clearance) == (band.nodes.tolist(), band.edge_clearance)


def test_version_1_table_names_fields_of_today() -> None:
    for name in FIELDS.keys() & EXAMPLES.keys():
        assert set(FIELDS[name].values()) <= to_dict(EXAMPLES[name]).keys()


def test_version_2_has_no_old_names() -> None:
    with pytest.raises(InputError, match=r"^reaction is not a field"):
        from_dict(TrackerSettings, {"version": 2, "reaction": 1.0})


@pytest.mark.parametrize("name", sorted(EXAMPLES))
@given(data=st.data())
def test_round_trip_preserves_any_numbers(name: str, data: st.DataObject) -> None:
    value = EXAMPLES[name]
    if not dataclasses.is_dataclass(value):
        return
    for field in dataclasses.fields(value):
        if type(number := getattr(value, field.name)) is float:
            factor = data.draw(st.floats(0.5, 2.0), label=field.name)
            with suppress(InputError):  # out of the field's range
                value = dataclasses.replace(value, **{field.name: factor * number})
    assert parts(round_trip(value)) == parts(value)


@given(value=st.floats())
def test_every_float_is_preserved(value: float) -> None:
    again = round_trip(RemoteVehicle(id="a", x=value, y=0.0, psi=0.0, v_x=0.0))
    assert math.copysign(1.0, again.x) == math.copysign(1.0, value) or math.isnan(value)
    assert again.x == value or (math.isnan(again.x) and math.isnan(value))


def test_scenario_is_preserved() -> None:
    scenario = overtaking("2", Path([0.0, 1200.0], [[[0.0, 0.0, 1200.0, 0.0], [0.0] * 4]]))
    assert parts(round_trip(scenario)) == parts(scenario)
    assert from_dict(Scenario, to_dict(scenario)).road.lanes == scenario.road.lanes


def test_restored_band_is_usable() -> None:
    band: Band = EXAMPLES["Band"]
    again = round_trip(band)
    assert again.status is Status.OK
    assert again.residual == band.residual
    assert np.array_equal(again.path().coefficients, band.path().coefficients)
    assert not again.nodes.flags.writeable


def test_batch_of_bands_is_described_one_by_one() -> None:
    many = relax_band(np.stack([ROUTE.sample(5.0)] * 2), vehicle=CAR)
    with pytest.raises(InputError, match=r"Band\.status"):
        to_dict(many)
    assert parts(round_trip(many[1])) == parts(many[1])


def test_infinity_is_written_as_string() -> None:
    data = to_dict(EvasionSettings(awareness_range=math.inf))
    assert data["awareness_range"] == "Infinity"
    assert from_dict(EvasionSettings, {"awareness_range": "Infinity"}).awareness_range == math.inf
    with pytest.raises(InputError, match=r"^clearance must be finite"):
        from_dict(EvasionSettings, {"clearance": "Infinity"})


def test_omitted_fields_take_defaults() -> None:
    settings = from_dict(TrackerSettings, {"max_tracks": 50, "plausibility": {"frozen": False}})
    assert settings.max_tracks == 50
    assert not settings.plausibility.frozen
    assert settings.plausibility.yaw
    assert from_dict(ChannelSettings, {}) == ChannelSettings()


WRONG = [
    (
        Lane, {"d": 0.0, "wide": 3.5},
        r"^wide is not a field of Lane; did you mean width\? it has d, width, direction, boundaries$",
    ),
    (Lane, {"width": 3.5}, r"^d is missing, a field of Lane$"),
    (Lane, {"d": "left"}, r"^d must be a number, was 'left'$"),
    (Lane, {"d": True}, r"^d must be a number, was 'True'$"),
    (Lane, {"d": None}, r"^d must be a number"),
    (Lane, {"d": 10**400}, r"^d must be a number"),
    (Lane, {"d": 0.0, "direction": 1.0}, r"^direction must be a whole number"),
    (Lane, {"d": 0.0, "width": -1.0}, r"^width must be greater than 0, was -1$"),
    (Lane, {"d": 0.0, "type": "Road"}, r"^type must be Lane, was 'Road'$"),
    (Lane, {"d": 0.0, "version": 3}, r"^version must be 1 or 2, was 3$"),
    (Lane, [0.0], r"^data must have the fields of Lane"),
    (Lane, None, r"^data must have the fields of Lane"),
    (
        TrackerSettings,
        {"plausibility": {"position_tolerance": -1.0}},
        r"^plausibility\.position_tolerance must be",
    ),
    (TrackerSettings, {"plausibility": {"frozen": 1}}, r"^plausibility\.frozen must be true or false"),
    (TrackerSettings, {"plausibility": {"version": 2}}, r"^plausibility\.version is not a field"),
    (Decision, {"action": "TURN", "reason": ""}, r"^action must be one of KEEP, FOLLOW, .*, was 'TURN'$"),
    (Decision, {"action": [], "reason": ""}, r"^action must be one of KEEP"),
    (Decision, {"action": "KEEP", "reason": 1}, r"^reason must be a string"),
    (Decision, {"action": "KEEP", "reason": "", "danger_zone": [1.0]}, r"^danger_zone must be a list of 2"),
    (
        Decision,
        {"action": "KEEP", "reason": "", "danger_zone": [1.0, {}]},
        r"^danger_zone\[1\] must be a number",
    ),
    (Path, {"breaks": [0.0, 1.0], "coefficients": [[1.0], 2.0]}, r"^coefficients must be nested lists"),
    (Path, {"breaks": [0.0, "1"], "coefficients": []}, r"^breaks must be a number, was '1'$"),
    (Path, {"breaks": {"shape": [3]}, "coefficients": []}, r"^breaks must be nested lists"),
    (Path, {"breaks": {"shape": [0, -1]}, "coefficients": []}, r"^breaks must be nested lists"),
    (Path, {"breaks": {"shape": [0, 10**30]}, "coefficients": []}, r"^breaks must be nested lists"),
    (Road, {"path": to_dict(ROUTE), "lanes": [], "speed_limit": 1.0}, r"^path\.version is not a field"),
]  # fmt: skip


@pytest.mark.parametrize(("kind", "data", "words"), WRONG)
def test_error_names_field(kind: type, data: Any, words: str) -> None:
    with pytest.raises(InputError, match=words):
        from_dict(kind, data)


def test_error_names_nested_field() -> None:
    data = to_dict(EXAMPLES["Road"])
    data["lanes"][1]["width"] = "wide"
    with pytest.raises(InputError, match=r"^lanes\[1\]\.width must be a number, was 'wide'$"):
        from_dict(Road, data)


JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=8),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=8), inner, max_size=3),
    max_leaves=8,
)


@given(data=st.data())
def test_random_data_raises_input_error(data: st.DataObject) -> None:
    name = data.draw(st.sampled_from(sorted(EXAMPLES)))
    described = to_dict(EXAMPLES[name])
    described[data.draw(st.sampled_from(sorted(described)))] = data.draw(JSON)
    with suppress(InputError):
        from_dict(type(EXAMPLES[name]), described)


@pytest.mark.parametrize("value", [None, 3, "KEEP", Status.OK, Lane, [Lane(d=0.0)], object()])
def test_value_that_is_no_record_raises(value: object) -> None:
    with pytest.raises(InputError, match=r"^value must be settings or a result"):
        to_dict(value)


@pytest.mark.parametrize("kind", [None, 3, Lane(d=0.0), float, dict, Status])
def test_kind_that_is_no_record_raises(kind: Any) -> None:
    with pytest.raises(InputError, match=r"^kind must be a class"):
        from_dict(kind, {})


def test_record_with_unknown_object_raises() -> None:
    with pytest.raises(InputError, match=r"^RemoteVehicle\.x must be made of numbers"):
        to_dict(RemoteVehicle(id="a", x=object(), y=0.0, psi=0.0, v_x=0.0))  # type: ignore[arg-type]


def test_numpy_numbers_are_plain_numbers() -> None:
    data = to_dict(BandStiffness(k_s=np.float64(2.0), k_b=np.int64(3)))  # type: ignore[arg-type]
    assert json.loads(json.dumps(data))["k_b"] == 3
    assert type(data["k_s"]) is float


def test_description_is_readable() -> None:
    assert to_dict(VehicleParams.bmw_320i())["m"] == 1093.3
    assert list(to_dict(Lane(d=1.0))) == ["type", "version", "d", "width", "direction", "boundaries"]
