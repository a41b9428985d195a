"""A batch of bands equals single bands."""

import sys
from concurrent.futures import ThreadPoolExecutor
from dataclasses import fields

import numpy as np
import pytest

from cca_core.band import Band, relax_band
from cca_core.errors import InfeasibleError, InputError, Status
from cca_core.geometry import Boxes, boxes
from tests.support.band_scenes import CAR, straight

COUNT, NODES = 64, 120


def batch(rng: np.random.Generator, bands: int = COUNT, mesh: bool = False) -> dict:
    """Different routes, obstacles, edges and limits; some are infeasible."""
    h = rng.uniform(0.5, 2.0, bands) if mesh else np.ones(bands)
    kappa = rng.choice((0.0, 0.005, -0.01), bands)
    psi = rng.uniform(-3.0, 3.0, (bands, 1)) + kappa[:, None] * h[:, None] * np.arange(NODES)
    steps = h[:, None, None] * np.stack((np.cos(psi), np.sin(psi)), axis=-1)
    nodes = np.cumsum(steps, axis=1) + rng.uniform(-100.0, 100.0, (bands, 1, 2))
    rows, obstacles = np.arange(bands), []
    for fraction in (0.35, 0.65):
        at = (rng.uniform(fraction - 0.05, fraction + 0.05, bands) * NODES).astype(int)
        d, speed = rng.uniform(-3.0, 3.0, bands), rng.uniform(-0.3, 0.3, bands) * h
        heading = psi[rows, at]
        normal = np.column_stack((-np.sin(heading), np.cos(heading)))
        middle = nodes[rows, at] + d[:, None] * normal
        along = speed[:, None] * (np.arange(NODES) - at[:, None])
        x = middle[:, :1] + along * np.cos(heading)[:, None]
        y = middle[:, 1:] + along * np.sin(heading)[:, None]
        turned = heading + rng.uniform(-0.2, 0.2, bands)
        obstacles.append(
            Boxes(
                x, y, np.repeat(turned[:, None], NODES, axis=1), np.full((bands, NODES), 4.5), np.array(1.8)
            )
        )
    edge = np.repeat(rng.uniform(2.0, 6.0, (bands, 1)), NODES, axis=1)
    return {
        "nodes": nodes, "obstacles": obstacles, "vehicle": CAR, "clearance": 0.5, "corridor": (-edge, edge),
        "curvature_limit": np.repeat(rng.uniform(0.01, 0.1, (bands, 1)), NODES, axis=1),
    }  # fmt: skip


def single(arguments: dict, at: tuple[int, ...]) -> dict:
    """Arguments of one band of a batch."""

    def part(o: Boxes) -> Boxes:
        shape = arguments["nodes"].shape[:-1]
        return Boxes(*(np.broadcast_to(f, shape)[at] for f in (o.x, o.y, o.psi, o.length, o.width)))

    return {
        **arguments, "nodes": arguments["nodes"][at], "obstacles": [part(o) for o in arguments["obstacles"]],
        "corridor": tuple(edge[at] for edge in arguments["corridor"]),
        "curvature_limit": arguments["curvature_limit"][at],
    }  # fmt: skip


def assert_same(band: Band, alone: Band) -> None:
    for field in fields(Band):
        value, expected = getattr(band, field.name), getattr(alone, field.name)
        if field.name != "problem":
            assert type(value) is type(expected), field.name
            np.testing.assert_array_equal(value, expected, err_msg=field.name)
    assert band.sides == alone.sides
    assert band.residual == alone.residual
    np.testing.assert_array_equal(band.path().coefficients, alone.path().coefficients)


@pytest.mark.parametrize("side", [None, "left", "right", ["left", "right"]])
@pytest.mark.parametrize("mesh", [False, True])
def test_batch_equals_single_bands(side: object, mesh: bool) -> None:
    arguments = batch(np.random.default_rng(1), mesh=mesh)
    many = relax_band(**arguments, side=side)  # type: ignore[arg-type]
    for i in range(COUNT):
        assert_same(many[i], relax_band(**single(arguments, (i,)), side=side))  # type: ignore[arg-type]


@pytest.mark.parametrize("threads", [2, 3, 100])
def test_threads_give_the_same_bits(threads: int) -> None:
    arguments = batch(np.random.default_rng(7))
    many, one = (relax_band(**arguments, threads=count) for count in (threads, 1))
    for i in range(COUNT):
        assert_same(many[i], one[i])


@pytest.mark.parametrize("threads", [0, -1, 1.5, "2"])
def test_invalid_threads_raise(threads: object) -> None:
    with pytest.raises(InputError, match=r"^threads must be an integer of at least 1, was"):
        relax_band(straight(), vehicle=CAR, threads=threads)  # type: ignore[arg-type]


def test_callers_in_threads_do_not_disturb_each_other() -> None:
    arguments = batch(np.random.default_rng(8), 24)
    expected = relax_band(**arguments)
    with ThreadPoolExecutor(4) as pool:
        found = list(pool.map(lambda i: relax_band(**single(arguments, (i % 24,))), range(96)))
    for i, band in enumerate(found):
        assert_same(expected[i % 24], band)


def test_batch_fields_have_batch_shape() -> None:
    many = relax_band(**batch(np.random.default_rng(2)))
    assert many.nodes.shape == (COUNT, NODES, 2)
    for name in ("displacement", "lower", "upper"):
        assert getattr(many, name).shape == (COUNT, NODES)
    for name in (
        "clearance",
        "edge_clearance",
        "curvature",
        "spacing",
        "status",
        "message",
        "active_constraint",
        "active_obstacle",
        "n_solves",
    ):
        assert getattr(many, name).shape == (COUNT,)
    assert many.passes_left.shape == (2, COUNT)
    assert many.ok.dtype == bool
    assert 0 < many.ok.sum() < COUNT
    assert set(many.status) == {Status.OK, Status.INFEASIBLE}
    np.testing.assert_array_equal(many.ok, [status is Status.OK for status in many.status])
    assert repr(many) == f"Band(({COUNT},) bands, {many.ok.sum()} OK)"
    assert len(set(many.active_constraint)) > 3
    for name, obstacle in zip(many.active_constraint, many.active_obstacle, strict=True):
        assert (name == f"obstacle {obstacle}") == (obstacle is not None)
    for array in (many.nodes, many.displacement, many.lower, many.upper, many.passes_left):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = array[1]


def test_indexing_a_batch() -> None:
    many = relax_band(**batch(np.random.default_rng(3), 4))
    assert many[-1].clearance == many[3].clearance
    assert isinstance(many[0].clearance, float)
    assert many[0].status is many.status[0]
    assert many[0].nodes.shape == (NODES, 2)
    with pytest.raises(IndexError):
        many[4]
    with pytest.raises(InputError, match="single band"):
        many[0][0]
    for use in (lambda: many.side, lambda: many.sides, lambda: many.residual, many.path):
        with pytest.raises(InputError, match="was a batch"):
            use()


def test_require_of_batch() -> None:
    many = relax_band(**batch(np.random.default_rng(4)))
    with pytest.raises(InfeasibleError) as caught:
        many.require()
    assert caught.value.result is many
    assert str(caught.value) == many.message[np.flatnonzero(~many.ok)[0]]
    fine = relax_band(**{**batch(np.random.default_rng(4)), "obstacles": [], "curvature_limit": 1.0})
    assert fine.require() is fine


def test_batch_of_two_axes_equals_single_bands() -> None:
    flat = batch(np.random.default_rng(5), 6)

    def folded(values: np.ndarray) -> np.ndarray:
        return np.broadcast_to(values, (6, NODES)).reshape(2, 3, NODES)

    arguments = {
        **flat, "nodes": flat["nodes"].reshape(2, 3, NODES, 2),
        "corridor": tuple(edge.reshape(2, 3, NODES) for edge in flat["corridor"]),
        "curvature_limit": flat["curvature_limit"].reshape(2, 3, NODES),
        "obstacles": [Boxes(*(folded(getattr(o, f.name)) for f in fields(Boxes))) for o in flat["obstacles"]],
    }  # fmt: skip
    many = relax_band(**arguments)
    assert many.status.shape == (2, 3)
    assert many[1].status.shape == (3,)
    assert many.passes_left.shape == (2, 2, 3)
    for i in range(2):
        for j in range(3):
            assert_same(many[i][j], relax_band(**single(arguments, (i, j))))


def test_previous_of_batch() -> None:
    arguments = batch(np.random.default_rng(6), 8)
    first = relax_band(**arguments)
    again = relax_band(**arguments, previous=first)
    for i in range(8):
        alone = relax_band(**single(arguments, (i,)), previous=first[i])
        assert_same(again[i], alone)


def test_obstacles_and_edges_broadcast() -> None:
    """Obstacles and edges of shape () hold for all bands."""
    nodes = np.array([straight() + np.array((0.0, d)) for d in (-1.0, 0.0, 1.0)])
    one = [boxes(75.0, 0.0, 0.0, 4.5, 1.8)]
    for corridor in (None, (-6.0, 6.0)):
        many = relax_band(nodes, one, vehicle=CAR, corridor=corridor)
        for i in range(3):
            assert_same(many[i], relax_band(nodes[i], one, vehicle=CAR, corridor=corridor))
    assert not np.array_equal(many[0].displacement, many[1].displacement)


def test_band_within_a_band_changes_nothing() -> None:
    """A signal handler may plan too, between any two steps of a call."""
    route, one, other = straight(60.0, 1.0), boxes(30.0, 0.5, 0.0, 4.5, 1.8), boxes(28.0, -0.3, 0.1, 4.0, 2.0)
    expected, calls = relax_band(route, [one], vehicle=CAR), []

    def interrupt(*_: object) -> None:
        sys.setprofile(None)
        calls.append(relax_band(route, [other], vehicle=CAR))
        sys.setprofile(interrupt)

    sys.setprofile(interrupt)
    try:
        band = relax_band(route, [one], vehicle=CAR)
    finally:
        sys.setprofile(None)
    assert len(calls) > 10
    np.testing.assert_array_equal(band.displacement, expected.displacement)
