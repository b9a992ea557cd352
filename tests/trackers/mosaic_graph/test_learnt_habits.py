"""What is learnt of drivers while they are seen: side and place of the lane, and how briskly the target drives."""

from __future__ import annotations

import numpy as np
import pytest

from tests.trackers.drawn_town import ROAD_WIDTH_M, film
from tests.trackers.mosaic_graph.test_roads import HABITS, crossing, nothing_unseen, roads_of
from trackers import registry
from trackers.mosaic_graph.kernels import road_position as rp
from trackers.mosaic_graph.kernels.road_course import weight_of_turn
from trackers.mosaic_graph.motion_model import CarModel, Instant, LaneOffset
from trackers.mosaic_graph.road_graph import build_graph
from trackers.particle_filter import ParticleFilter

_LANE_M, _N = 1.7, 20
STREET = roads_of(build_graph([np.linspace([-90.0, 0.0], [90.0, 0.0], 361)], nothing_unseen))


@pytest.mark.parametrize("right", [1.0, -1.0])
@pytest.mark.parametrize("east", [1.0, -1.0])
def test_the_lane_is_learnt_within_20_sightings_on_either_side(right: float, east: float) -> None:
    rng = np.random.default_rng(3)
    lane = LaneOffset()
    for k in range(_N):
        position = np.array([east * (0.5 * k - 20.0), -right * east * _LANE_M]) + rng.normal(0, 0.3, 2)
        lane.learn(position, np.array([7.5 * east, 0.0]), STREET, 1.0)
    assert lane.mean_m == pytest.approx(right * _LANE_M, abs=0.35)
    assert lane.spread_m < 0.25 * LaneOffset().spread_m


def test_at_first_neither_side_is_preferred() -> None:
    assert LaneOffset().mean_m == 0.0
    assert LaneOffset().spread_m == pytest.approx(0.5 * 3.25)


@pytest.mark.parametrize(
    ("place_m", "velocity_mps"),
    [((-20.0, -1.7), (0.5, 0.0)), ((-20.0, -1.7), (5.0, 5.0)), ((-20.0, -5.0), (7.0, 0.0)), ((-4.0, -1.7), (7.0, 0.0))],
    ids=["standing", "across", "off the road", "on the crossing"],
)
def test_no_lane_is_learnt_where_none_is_seen(place_m: tuple[float, float], velocity_mps: tuple[float, float]) -> None:
    lane = LaneOffset()
    lane.learn(np.array(place_m), np.array(velocity_mps), roads_of(crossing()), 1.0)
    assert lane == LaneOffset()
    lane.learn(np.array([-20.0, -1.7]), np.array([7.0, 0.0]), roads_of(crossing()), 1.0)
    assert lane.mean_m > 0.5


def test_turning_changes_the_weight_of_a_way_smoothly() -> None:
    turns = np.arange(0.0, np.pi, 0.01)
    weights = np.array([weight_of_turn(turn, 0.5) for turn in turns])
    assert weights[0] == pytest.approx(1.0, abs=1e-5)
    assert weight_of_turn(-np.pi / 2, 0.5) == pytest.approx(0.5, abs=0.02)
    assert weights[-1] < 0.02
    assert (np.diff(weights) <= 0).all()
    assert np.abs(np.diff(weights)).max() < 0.02


def _vigour_of(acceleration_mps2: float) -> float:
    """Return the particles' mean factor of acceleration after they saw a car start from a halt for 3 s."""
    habits = HABITS._replace(
        acceleration=1.0, cruise_mps=11.0, vigour_spread=0.5, urge_spread=0.3, speed_noise=0.2, style_rate=0.05
    )
    model = CarModel(np.array([-60.0, 0.0]), 0.0, habits, 0.1, 0.6, True, 0.25, 2.0)
    model.detectable = lambda positions_m, camera: np.full(len(positions_m), 0.6)  # type: ignore[method-assign]
    rng = np.random.default_rng(5)
    particles = ParticleFilter(model, 1000, rng)
    particles.states[:, [rp.HEADING, rp.SPEED]] = 0.0
    for frame in range(1, 46):
        place = np.array([[-60.0 + 0.5 * acceleration_mps2 * (frame / 15) ** 2, 0.0]])
        seen = np.array([0.0]), np.array([5.0]), np.array([0.0])
        particles.step(Instant(1 / 15, None, STREET, False, place, *seen, ()))
    return float(np.exp(particles.states[:, rp.VIGOUR]).mean())


def test_the_filter_selects_brisk_particles_for_a_brisk_driver() -> None:
    slow, brisk = _vigour_of(0.5), _vigour_of(2.5)
    assert slow < 0.9
    assert brisk > 1.4


@pytest.mark.heavy
@pytest.mark.parametrize("lane_y_m", [-ROAD_WIDTH_M / 4, ROAD_WIDTH_M / 4], ids=["right", "left"])
def test_out_of_view_particles_keep_to_the_side_on_which_the_car_was_seen(lane_y_m: float) -> None:
    frames = film(0, 40, out=(24, 60), with_ego=True, decoys=0, lane_y_m=lane_y_m)
    tracker = registry.entry("mosaic_graph_pf").create(np.random.default_rng(0), particles=400)
    tracker.initialise(frames[0].observation, frames[0].box_xyxy)
    for frame in frames[1:]:
        said = tracker.update(frame.observation)
    assert not frames[-1].inside
    half_length_px = np.linalg.norm(frames[-1].along_px)
    left = np.array([frames[-1].along_px[1], -frames[-1].along_px[0]]) / half_length_px
    aside_m = 2.25 * np.median((said.particles_px - frames[-1].car_px) @ left) / half_length_px
    assert abs(aside_m) < 0.3 * ROAD_WIDTH_M / 2
