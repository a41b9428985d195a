"""Danger zone: eq 11 as printed; the general form against hand values and a simulation."""

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cca_core import InputError
from cca_core.decide import danger_zone, danger_zone_end

LENGTH = 4.5


def zone(rear: float, front: float, v_adj: float, v_ego: float, t: float, **kwargs: Any) -> Any:
    """Zone for an ego at constant speed."""
    return danger_zone(rear, front, v_adj, times=[0.0, t], ego_travel=[0.0, v_ego * t], **kwargs)


class TestEquation11:
    def test_end_is_printed_sum(self) -> None:
        assert float(danger_zone_end(-40.0, 33.0, 21.0, 5.0, 7.0)) == -40.0 + 12.0 * 5.0 + 7.0

    def test_signed_and_unsigned_speed_differ_by_160_m(self) -> None:
        # 20 / -20 m/s, 4 s, x_s 10: printed with a signed speed -150 m, read unsigned +10 m
        assert float(danger_zone_end(0.0, -20.0, 20.0, 4.0, 10.0)) == -150.0
        assert float(danger_zone_end(0.0, 20.0, 20.0, 4.0, 10.0)) == 10.0

    def test_end_broadcasts(self) -> None:
        end = danger_zone_end([[0.0], [10.0]], [30.0, 25.0, 20.0], 20.0, 4.0, 10.0)
        assert end.tolist() == [[50.0, 30.0, 10.0], [60.0, 40.0, 20.0]]

    @pytest.mark.parametrize("t", [-1.0, math.nan, math.inf, "soon", None])
    def test_invalid_duration_raises(self, t: Any) -> None:
        with pytest.raises(InputError, match="t_maneuver"):
            danger_zone_end(0.0, 30.0, 20.0, t, 10.0)

    @pytest.mark.parametrize("bad", [math.nan, math.inf])
    def test_invalid_safety_distance_raises(self, bad: float) -> None:
        with pytest.raises(InputError, match="x_safety"):
            danger_zone_end(0.0, 30.0, 20.0, 4.0, bad)


class TestSingleCases:
    def test_front_end_is_x2_for_faster_vehicle_behind(self) -> None:
        front = -40.0
        z = zone(front - LENGTH, front, 30.0, 20.0, 4.0, x_safety=10.0)
        assert z[1] == pytest.approx(float(danger_zone_end(front, 30.0, 20.0, 4.0, 10.0)))
        assert z[0] == pytest.approx(front - LENGTH - 10.0)  # the vehicle only comes closer

    def test_oncoming_zone_reaches_170_m_toward_ego(self) -> None:
        # its front, nearest to the ego, is the min_gap path coordinate of its body
        z = zone(0.0, LENGTH, -20.0, 20.0, 4.0, x_safety=10.0)
        assert z[0] == pytest.approx(-170.0)
        assert z[1] == pytest.approx(LENGTH + 10.0)

    def test_oncoming_170_m_ahead_just_reaches_ego(self) -> None:
        assert zone(170.0 - 1e-6, 175.0, -20.0, 20.0, 4.0, x_safety=10.0)[0] < 0.0
        assert zone(170.0 + 1e-6, 175.0, -20.0, 20.0, 4.0, x_safety=10.0)[0] > 0.0

    def test_slower_vehicle_ahead_counts_with_its_rear(self) -> None:
        z = zone(50.0, 50.0 + LENGTH, 12.0, 20.0, 5.0, x_safety=7.0)
        assert z[0] == pytest.approx(50.0 - 8.0 * 5.0 - 7.0)
        assert z[1] == pytest.approx(50.0 + LENGTH + 7.0)

    def test_alongside_at_equal_speed_zone_contains_body(self) -> None:
        z = zone(-1.0, 3.5, 20.0, 20.0, 6.0, x_safety=7.0)
        assert z.tolist() == pytest.approx([-8.0, 10.5])

    def test_alongside_without_safety_distance_zone_is_body(self) -> None:
        z = zone(-1.0, 3.5, 20.0, 20.0, 6.0, x_safety=0.0)
        assert z.tolist() == pytest.approx([-1.0, 3.5])

    def test_stationary_vehicle_is_passed_within_maneuver(self) -> None:
        z = zone(30.0, 34.5, 0.0, 20.0, 4.0, x_safety=0.0)
        assert z[0] == pytest.approx(-50.0)
        assert z[1] == pytest.approx(34.5)

    def test_extreme_within_maneuver_is_found(self) -> None:
        # the ego first falls back, then catches up: the front end of the zone is at half time
        z = danger_zone(0.0, 4.0, 20.0, times=[0.0, 2.0, 4.0], ego_travel=[0.0, 30.0, 90.0], x_safety=0.0)
        assert z.tolist() == pytest.approx([-10.0, 14.0])

    def test_acceleration_limit_grows_with_time_squared(self) -> None:
        z = zone(0.0, 4.0, 20.0, 20.0, 4.0, x_safety=1.0, braking=2.0, acceleration=2.0)
        assert z.tolist() == pytest.approx([-1.0 - 16.0, 4.0 + 1.0 + 16.0])

    def test_margin_is_added_at_both_ends(self) -> None:
        assert zone(0.0, 4.0, 20.0, 20.0, 4.0, x_safety=1.0, margin=3.0).tolist() == pytest.approx(
            [-4.0, 8.0]
        )


positions = st.floats(-300.0, 300.0)
sizes = st.floats(0.5, 25.0)
speeds = st.floats(-40.0, 40.0)
growths = st.floats(0.0, 20.0)
durations = st.floats(0.1, 15.0)


class TestProperties:
    @given(
        positions,
        sizes,
        speeds,
        st.floats(0.0, 40.0),
        durations,
        growths,
        growths,
        growths,
        growths,
        st.floats(0.0, 5.0),
    )
    def test_larger_margins_never_shrink_zone(
        self, x: float, length: float, v: float, v_ego: float, t: float,
        x_safety: float, more: float, margin: float, longer: float, a: float,
    ) -> None:  # fmt: skip
        def z(x_s: float, m: float, bound: float, until: float) -> Any:
            times = np.append(np.linspace(0.0, t, 9), until)
            return danger_zone(
                x, x + length, v, times=times, ego_travel=v_ego * times,
                x_safety=x_s, margin=m, braking=bound, acceleration=bound,
            )  # fmt: skip

        base = z(x_safety, margin, a, t)
        for wider in (
            z(x_safety + more, margin, a, t),
            z(x_safety, margin + more, a, t),
            z(x_safety, margin, a + more, t),
            z(x_safety, margin, a, t + longer),
        ):
            assert wider[0] <= base[0] + 1e-9
            assert wider[1] >= base[1] - 1e-9

    @given(positions, sizes, speeds, st.floats(0.0, 40.0), st.floats(-2.0, 2.0), durations, growths)
    def test_zone_contains_body_at_every_sample(
        self, x: float, length: float, v: float, v_ego: float, a: float, t: float, x_safety: float
    ) -> None:
        times = np.linspace(0.0, t, 13)
        travel = np.maximum.accumulate(v_ego * times + 0.5 * a * times**2)
        rear, front = danger_zone(x, x + length, v, times=times, ego_travel=travel, x_safety=x_safety)
        for moment, driven in zip(times.tolist(), travel.tolist(), strict=True):
            assert rear <= x + v * moment - driven - x_safety + 1e-9
            assert front >= x + length + v * moment - driven + x_safety - 1e-9
        # and is not larger than that anywhere
        assert rear == pytest.approx(
            min(x + v * k - e for k, e in zip(times, travel, strict=True)) - x_safety
        )
        assert front == pytest.approx(
            max(x + length + v * k - e for k, e in zip(times, travel, strict=True)) + x_safety
        )

    @given(positions, sizes, speeds, st.floats(0.0, 40.0), durations, growths)
    def test_zone_is_mirrored_along_road(
        self, x: float, length: float, v: float, v_ego: float, t: float, x_safety: float
    ) -> None:
        """All signs reversed reverse the zone: no direction is special."""
        times = np.linspace(0.0, t, 7)
        z = danger_zone(x, x + length, v, times=times, ego_travel=v_ego * times, x_safety=x_safety)
        m = danger_zone(-x - length, -x, -v, times=times, ego_travel=-v_ego * times, x_safety=x_safety)
        assert m.tolist() == pytest.approx([-z[1], -z[0]])

    @given(positions, sizes, speeds, st.floats(0.0, 40.0), durations, st.randoms(use_true_random=False))
    def test_order_of_samples_has_no_effect(
        self, x: float, length: float, v: float, v_ego: float, t: float, random: Any
    ) -> None:
        times = np.linspace(0.0, t, 7)
        order = list(range(7))
        random.shuffle(order)
        z = danger_zone(
            x, x + length, v, times=times, ego_travel=v_ego * times, braking=1.0, acceleration=1.0
        )
        w = danger_zone(
            x,
            x + length,
            v,
            times=times[order],
            ego_travel=(v_ego * times)[order],
            braking=1.0,
            acceleration=1.0,
        )
        assert z.tolist() == w.tolist()

    @given(positions, sizes, speeds, st.floats(0.0, 40.0), durations)
    def test_constant_speeds_need_only_both_ends(
        self, x: float, length: float, v: float, v_ego: float, t: float
    ) -> None:
        times = np.linspace(0.0, t, 50)
        fine = danger_zone(x, x + length, v, times=times, ego_travel=v_ego * times)
        assert fine.tolist() == pytest.approx(zone(x, x + length, v, v_ego, t).tolist())

    @given(st.floats(-200.0, 200.0), st.floats(-35.0, 35.0), st.floats(5.0, 35.0), durations)
    def test_zone_blocks_exactly_below_safety_distance(
        self, x: float, v: float, v_ego: float, t: float
    ) -> None:
        """A simulation in small steps: the ego overlaps the zone if and only if the gap is below x_s."""
        half, x_s = 0.5 * LENGTH, 7.0
        rear, front = zone(x, x + LENGTH, v, v_ego, t, x_safety=x_s)
        moments = np.linspace(0.0, t, 4001)
        other = x + (v - v_ego) * moments
        gap = np.maximum(other - half, -half - (other + LENGTH))
        min_gap = float(gap.min())
        if abs(min_gap - x_s) > 0.1:
            blocked = rear <= half and front >= -half
            assert blocked == (min_gap < x_s)


def test_batch_equals_scalar() -> None:
    rng = np.random.default_rng(7)
    rear = rng.uniform(-200.0, 200.0, (4, 3))
    length, v, margin = (
        rng.uniform(3.0, 20.0, (4, 3)),
        rng.uniform(-40.0, 40.0, (4, 3)),
        rng.uniform(0, 9, (4, 3)),
    )
    times = np.linspace(0.5, 6.0, 11)
    travel = 18.0 * times + 0.4 * times**2
    together = danger_zone(
        rear, rear + length, v, times=times, ego_travel=travel, margin=margin, braking=0.7, acceleration=0.7
    )
    assert together.shape == (4, 3, 2)
    for i in np.ndindex(4, 3):
        alone = danger_zone(
            rear[i],
            rear[i] + length[i],
            v[i],
            times=times,
            ego_travel=travel,
            margin=margin[i],
            braking=0.7,
            acceleration=0.7,
        )
        assert alone.tolist() == together[i].tolist()


def test_one_margin_for_many_vehicles() -> None:
    z = danger_zone([0.0, 10.0], [4.0, 14.0], 20.0, times=[0.0], ego_travel=[0.0], margin=2.0, x_safety=0.0)
    assert z.tolist() == [[-2.0, 6.0], [8.0, 16.0]]


@pytest.mark.parametrize(
    ("kwargs", "named"),
    [
        ({"times": [0.0, 1.0, 2.0]}, "times"),
        ({"times": [], "ego_travel": []}, "times"),
        ({"times": [-0.1, 1.0]}, "times"),
        ({"times": [0.0, math.nan]}, "times"),
        ({"times": 3.0}, "times"),
        ({"ego_travel": [0.0, math.inf]}, "ego_travel"),
        ({"ego_travel": [[0.0, 1.0]]}, "ego_travel"),
        ({"x_safety": -1.0}, "x_safety"),
        ({"x_safety": math.nan}, "x_safety"),
        ({"braking": -0.1}, "braking"),
        ({"acceleration": math.inf}, "acceleration"),
        ({"margin": -1.0}, "margin"),
        ({"margin": math.nan}, "margin"),
        ({"rear": math.nan}, "rear"),
        ({"front": math.inf}, "front"),
        ({"v_adj": math.nan}, "v_adj"),
        ({"rear": 5.0, "front": 1.0}, "rear|front"),
    ],
)
def test_invalid_input_names_argument(kwargs: dict[str, Any], named: str) -> None:
    good = {"rear": 0.0, "front": 4.0, "v_adj": 20.0, "times": [0.0, 4.0], "ego_travel": [0.0, 80.0]}
    args = good | kwargs
    with pytest.raises(InputError, match=named):
        danger_zone(args.pop("rear"), args.pop("front"), args.pop("v_adj"), **args)
