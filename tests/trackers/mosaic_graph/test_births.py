"""Births of particles, and the evidence of sightings."""

from __future__ import annotations

import numpy as np
import pytest

from trackers.mosaic_graph.detector import Candidate
from trackers.mosaic_graph.kernels import oriented_box as ob
from trackers.mosaic_graph.sightings import LastSeen, Sighting, Sightings, may_be_target, renewal, surprise


def candidate(x_m: float, log_ratio: float, axis_rad: float = 0.0, covered: float = 1.0) -> Candidate:
    measures = np.zeros(ob.MEASURES)
    measures[ob.COVERED] = covered
    return Candidate(np.array([x_m, 0.0]), axis_rad, log_ratio, measures)


def sighting(x_m: float, velocity_mps: tuple[float, float] = (8.0, 0.0), axis_rad: float = 0.0) -> Sighting:
    seen = candidate(x_m, 4.0, axis_rad)
    return Sighting(seen, seen.position_m, np.array(velocity_mps), evidence=12.0, age=5)


def last_seen(since_s: float, speed_mps: float = 8.0) -> LastSeen:
    return LastSeen(np.zeros(2), speed_mps, since_s)


def test_a_sighting_out_of_reach_is_not_the_target() -> None:
    assert may_be_target(sighting(12.0), last_seen(1.0))
    assert not may_be_target(sighting(18.0), last_seen(1.0))
    assert may_be_target(sighting(18.0), last_seen(2.0))
    assert not may_be_target(sighting(12.0), last_seen(1.0, speed_mps=0.0))


def test_the_prior_of_a_surprise_depends_on_the_time_out_of_view() -> None:
    """It rises at first, as the particles may have lost the target, and then falls with the area."""
    priors = [surprise(sighting(0.0), last_seen(t), 0.2).log_prior for t in (0.2, 1.0, 3.0)]
    assert priors[0] < priors[1] - 1.5
    assert priors[1] < priors[2]
    assert surprise(sighting(0.0), last_seen(60.0), 0.2).log_prior < priors[2] - 3.0


@pytest.mark.parametrize(
    ("velocity_mps", "mean_rad", "expected_rad"), [((6, 0.5), 3.0, 0.1), ((0, 0), 3.0, 0.1 + np.pi)]
)
def test_a_newborns_heading_is_the_end_of_the_axis_in_the_direction_of_travel(
    velocity_mps: tuple[float, float], mean_rad: float, expected_rad: float
) -> None:
    birth = renewal(sighting(0.0, velocity_mps, axis_rad=0.1), mean_rad, 0.03)
    assert np.cos(birth.heading_rad - expected_rad) == pytest.approx(1.0)
    assert birth.log_prior == pytest.approx(np.log(0.03))
    assert birth.speed_mps == pytest.approx(max(0.0, 6 * np.cos(0.1) + 0.5 * np.sin(0.1) if velocity_mps[0] else 0.0))


def test_the_evidence_of_many_pictures_is_limited() -> None:
    sightings = Sightings()
    told = []
    for _ in range(30):
        sightings.update([candidate(0.0, 3.0)], 1 / 15)
        (only,) = sightings.current
        told.append(only.news)
    np.testing.assert_allclose(told[:3], [3.0, 3.0, 2.0], atol=1e-9)
    np.testing.assert_allclose(told[3:], 0.0, atol=1e-9)
    assert only.past_evidence == 8.0


def test_a_box_cut_by_the_border_hardly_moves_a_sighting() -> None:
    """The visible part of a standing car at the border is measured 0.8 m too far inside."""
    speeds_mps = []
    for covered in (1.0, 0.5):
        sightings = Sightings()
        for _ in range(10):
            sightings.update([candidate(0.0, 3.0)], 1 / 15)
        sightings.update([candidate(0.8, 3.0, covered=covered)], 1 / 15)
        speeds_mps.append(sightings.current[0].velocity_mps[0])
    assert speeds_mps[0] > 2.0
    assert speeds_mps[1] < 0.5


def test_a_sighting_is_followed_and_its_evidence_is_bounded() -> None:
    sightings = Sightings()
    for k in range(40):
        sightings.update([candidate(0.5 * k, 3.0), candidate(200.0, -5.0)], 1 / 15)
    assert len(sightings.current) == 1
    followed = sightings.current[0]
    assert followed.velocity_mps[0] == pytest.approx(7.5, rel=0.05)
    assert followed.evidence == pytest.approx(12.0, rel=0.01)
    for _ in range(6):
        sightings.update([], 1 / 15)
    assert sightings.current == []


def test_a_sighting_beside_the_target_is_ruled_out() -> None:
    sightings = Sightings()
    for _ in range(10):
        sightings.update([candidate(0.0, 4.0), candidate(30.0, 4.0)], 1 / 15)
        target, other = sightings.current
        sightings.rule_out_others(target)
    assert target.log_ratio == pytest.approx(4.0)
    assert other.log_ratio < 1.0
