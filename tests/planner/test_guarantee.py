"""Guarantee: vehicles within the declared bounds do not touch an ego on its certified safe stop.

Assumed of others: accelerations within the bounds of the settings (a vehicle that is being passed does not
accelerate), any function of time; places within two sigma of what the tracker says; they keep their lateral
offset or move sideways at most as reported. A vehicle behind the ego keeps its distance: at once if the ego
stays in its lane, and from 1 s after a return. Unless the settings are cautious, drivers behind in the
adjacent lane keep their speed from the begin of a maneuver on and their distance 1.5 s later, and those who
follow an ego that is outside its lane keep their distance.
"""

import numpy as np
import pytest

from tests.support.declared_motion import min_gap
from tests.support.guarantee import CAUTIOUS, DEFAULT, Case, Sender, decide, sample_case
from tests.support.guarantee_search import search
from tests.support.refusals import is_refused


def touched(block: int, count: int, *, reacts: bool) -> tuple[list[tuple[int, int, float]], int]:
    """Situations whose certified safe stop is touched, with the gap, and the number of certified ones."""
    found, certified = [], 0
    for i in range(count):
        decided = decide(sample_case(np.random.default_rng((block, i))), DEFAULT if reacts else CAUTIOUS)
        certificate = decided.command.certificate
        if certificate is None or not certificate.keeps_worst_case:
            continue
        certified += 1
        gap = min_gap(decided, np.random.default_rng((block, i, 1)), reacts=reacts)
        if gap < 0.0:
            found.append((block, i, gap))
    return found, certified


@pytest.mark.parametrize("reacts", [True, False])
def test_certified_safe_stop_is_not_touched(reacts: bool) -> None:
    found, certified = touched(0, 120, reacts=reacts)
    assert found == []
    assert certified >= 50


@pytest.mark.parametrize("index", [27, 139, 166])
def test_follower_that_comes_near_at_return_is_seen(index: int) -> None:
    """Between two steps: before its duty to keep its distance begins, or while the ego comes to rest."""
    decided = decide(sample_case(np.random.default_rng((1, index))), CAUTIOUS)
    certificate = decided.command.certificate
    assert certificate is not None
    gap = min_gap(decided, np.random.default_rng((1, index, 1)), reacts=False)
    assert gap > 0.0 or not certificate.keeps_worst_case


def test_follower_of_uncertain_lane_may_accelerate() -> None:
    """It may be in the lane that the ego is in, but is not for certain: it has no duty."""
    decided = decide(sample_case(np.random.default_rng((42, 674))), DEFAULT)
    certificate = decided.command.certificate
    assert certificate is not None
    gap = min_gap(decided, np.random.default_rng((42, 674, 1)), reacts=True)
    assert gap > 0.0 or not certificate.keeps_worst_case


def test_certificate_ends_when_lead_leaves_its_assumptions() -> None:
    """It begins to move sideways and is less certain than before: the last certificate is void."""
    lead = Sender(
        s=509.58536611112066, d=-0.04715679456279093, v=4.376045292499182, v_d=-0.3366989901297422,
        a=0.9621865252143762, age=0.9063056983645164, length=18.7, width=2.55, along=-0.5676758172462298,
        across=0.3409505740203025, first=0.9431464575333296, second=0.9611374000050785,
    )  # fmt: skip
    case = Case(
        road=13, v=3.8197317829576445, cruise=13.984662064905761, driven=1.7033550996802944, senders=(lead,)
    )
    decided = decide(case, CAUTIOUS)
    certificate = decided.command.certificate
    assert certificate is not None
    gap = min_gap(decided, np.random.default_rng(1), reacts=False)
    assert gap > 0.0 or not certificate.keeps_worst_case


def test_long_vehicle_that_leaves_its_lane_in_a_bend_is_seen() -> None:
    """Its center has passed the middle of its lane, the center of what it covers in the bend has not."""
    leads = (
        Sender(
            s=568.0263977429606, d=0.013048135880686054, v=15.244100529918104, v_d=-0.013821977645332887,
            a=-7.543050256317441, age=0.4359811340812752, length=12.0, width=2.55,
        ),
        Sender(
            s=530.9741043654776, d=-0.40030116612035144, v=18.372668898078057, v_d=-0.04650338630370769,
            a=0.16092536283387354, age=0.7521023808588064, length=18.7, width=2.55,
        ),
    )  # fmt: skip
    truck = Sender(
        s=503.36672528404335, d=-3.614764780375379, v=11.925843567010864, v_d=0.3710517942168286,
        a=1.461231435919287, age=0.04734133074135016, length=18.7, width=2.55, along=-0.6150599542087152,
        across=0.39681207000189256, first=1.0, second=-1.0, switch=5.276796081479668,
    )  # fmt: skip
    case = Case(road=34, v=16.796787264699294, cruise=32.73598245779199, senders=(*leads, truck))
    decided = decide(case, DEFAULT)
    certificate = decided.command.certificate
    assert certificate is not None
    assert min_gap(decided, np.random.default_rng(1)) > 0.0 or not certificate.keeps_worst_case


@pytest.mark.parametrize(("block", "index"), [(86, 8), (66, 331), (53, 854)])
def test_vehicle_that_may_be_alongside_is_seen(block: int, index: int) -> None:
    """Behind by its old report, but perhaps not now; a corner in the ego's lane, for less than a step too."""
    decided = decide(sample_case(np.random.default_rng((block, index))), DEFAULT)
    certificate = decided.command.certificate
    assert certificate is not None
    gap = min_gap(decided, np.random.default_rng((block, index, 1)))
    assert gap > 0.0 or not certificate.keeps_worst_case


@pytest.mark.parametrize(("block", "index"), [(34, 144), (47, 154), (62, 879), (138, 807), (150, 476)])
def test_motion_since_report_is_bounded(block: int, index: int) -> None:
    """It moved sideways, did not brake, is in the inner lane of a bend, is long and oblique, or stands."""
    reacts = block % 2 == 0
    decided = decide(sample_case(np.random.default_rng((block, index))), DEFAULT if reacts else CAUTIOUS)
    certificate = decided.command.certificate
    assert certificate is not None
    gap = min_gap(decided, np.random.default_rng((block, index, 1)), reacts=reacts)
    assert gap > 0.0 or not certificate.keeps_worst_case


def test_report_of_an_earlier_time_counts_as_it_is() -> None:
    """It was measured before the last one and tells of lateral motion: it is not that one grown older."""
    lead = Sender(
        s=534.7390179373783, d=1.0035896754313978, v=12.26363954108051, v_d=0.3560652065631123,
        a=-1.620943367378082, age=0.649066368340512, length=4.5, width=1.8, along=0.4109998980338052,
        across=-0.1274183989527822, first=0.9657844769730058, second=0.5978829395137153,
        switch=3.4649029764915227,
    )  # fmt: skip
    case = Case(
        road=12, v=21.031174861317457, cruise=30.770861180324474, driven=3.8972624081017138,
        sigma=0.1830174909230344, senders=(lead,),
    )  # fmt: skip
    decided = decide(case, CAUTIOUS)
    certificate = decided.command.certificate
    assert certificate is not None
    assert min_gap(decided, np.random.default_rng(1), reacts=False) > 0.0 or not certificate.keeps_worst_case


def test_passed_vehicle_may_have_braked_since_its_report() -> None:
    """It reported acceleration, which dead reckoning counts; it is not expected to accelerate further."""
    senders = (
        Sender(
            s=525.5308940013279, d=-0.48344568562912676, v=6.789816223941543,
            v_d=-0.33854258962427086, a=3.0, age=0.882687102938157, length=4.5, width=1.8,
            along=0.8889428367938016, across=-1.0, first=0.9950824335376349,
            second=0.06035870926321785, switch=6.691374843453784,
        ),
        Sender(
            s=528.4317004953879, d=-3.2497447266143737, v=23.68962747630462,
            v_d=0.1320288540055305, a=-1.4615628057907135, age=0.7793737926605375, length=12.0,
            width=2.55, along=0.2923331737201146, across=-0.8220857106844693, first=-1.0,
            second=-0.8459497266197588, switch=0.16794860444001786,
        ),
        Sender(
            s=528.6851695668685, d=-2.2599005227217397, v=35.77753298628746,
            v_d=0.9727149265124081, a=-0.5298990993236211, age=0.8154705561088346, length=4.5,
            width=1.8, along=-0.35885166691699555, across=-0.3426442673143284,
            first=0.8776780462228425, second=-0.9964818374597932, switch=3.3140459625100562,
        ),
    )  # fmt: skip
    case = Case(
        road=32, v=10.770710103981123, cruise=11.773562299627311, driven=4.6347214647948265,
        sigma=0.3297036824259719, senders=senders,
    )  # fmt: skip
    decided = decide(case, CAUTIOUS)
    certificate = decided.command.certificate
    assert certificate is not None
    assert min_gap(decided, np.random.default_rng(1), reacts=False) > 0.0 or not certificate.keeps_worst_case


@pytest.mark.slow
@pytest.mark.parametrize("block", range(1, 101))
def test_certified_safe_stop_is_not_touched_in_many(block: int) -> None:
    assert touched(block, 1000, reacts=block % 2 == 0)[0] == []


def test_search_finds_no_contact() -> None:
    assert min(search((0, i), DEFAULT, 25, reacts=True)[0] for i in range(3)) >= 0.0


@pytest.mark.slow
@pytest.mark.parametrize("block", range(1, 26))
def test_searches_find_no_contact(block: int) -> None:
    reacts = block % 2 == 0
    gaps = [search((block, i), DEFAULT if reacts else CAUTIOUS, 60, reacts=reacts)[0] for i in range(20)]
    assert [(i, gap) for i, gap in enumerate(gaps) if gap < 0.0] == []


@pytest.mark.slow
def test_safe_maneuvers_are_seldom_refused() -> None:
    """Of those that an oracle knows to be safe in the worst case, with any gap."""
    found = [is_refused(sample_case(np.random.default_rng((200, i))), DEFAULT) for i in range(300, 1200)]
    assert found.count(False) >= 60
    assert found.count(True) <= 0.1 * (found.count(True) + found.count(False))
