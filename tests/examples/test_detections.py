"""AP by COCO's tools against cases that can be counted, and which cars a detector has to find."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from scenarios.scenario import Frame
from tests.benchmarks.data.sets.hand_made import FRAMES, HandMadeEpisode

pytest.importorskip("pycocotools", reason="pycocotools is not installed")

from detections import average_precision, cars_seen

CAR, OTHER = [10.0, 10.0, 30.0, 22.0], [50.0, 40.0, 62.0, 60.0]
NONE = np.empty((0, 5))


def boxes(*rows: list[float]) -> np.ndarray:
    return np.array(rows)


def test_truth_against_itself_is_perfect() -> None:
    truth = [boxes([*CAR, 1.0], [*OTHER, 1.0]), NONE, boxes([*OTHER, 1.0], [*CAR, 0.0])]
    assert average_precision((each, each) for each in truth) == pytest.approx(1.0)


def test_ap_is_the_mean_precision_over_101_recalls() -> None:
    truth = boxes([*CAR, 1.0], [*OTHER, 1.0])
    # Half of the recalls, 0 to 0.5, are reached.
    assert average_precision([(truth, boxes([*CAR, 0.9]))]) == pytest.approx(51 / 101)
    # A surer detection of nothing halves the precision at all of them; a less sure one costs nothing.
    nothing = [100.0, 100.0, 120.0, 120.0]
    assert average_precision([(truth, boxes([*CAR, 0.5], [*nothing, 0.9]))]) == pytest.approx(51 / 101 / 2)
    assert average_precision([(truth, boxes([*CAR, 0.9], [*nothing, 0.5]))]) == pytest.approx(51 / 101)
    # A second box on the same car is false.
    assert average_precision([(truth, boxes([*CAR, 0.8], [*CAR, 0.9], [*OTHER, 0.7]))]) < 1.0
    assert average_precision([(truth, NONE), (NONE, boxes([*CAR, 1.0]))]) == 0.0


@pytest.mark.parametrize(("aside_px", "ap"), [(6.5, 1.0), (6.8, 0.0)])
def test_half_of_the_union_must_overlap(aside_px: float, ap: float) -> None:
    found = boxes([CAR[0] + aside_px, CAR[1], CAR[2] + aside_px, CAR[3], 0.9])
    assert average_precision([(boxes([*CAR, 1.0]), found)]) == pytest.approx(ap)


def test_cars_that_do_not_count_are_neither_right_nor_wrong() -> None:
    truth = boxes([*CAR, 1.0], [*OTHER, 0.0])
    assert average_precision([(truth, boxes([*CAR, 0.5]))]) == pytest.approx(1.0)
    assert average_precision([(truth, boxes([*CAR, 0.5], [*OTHER, 0.9]))]) == pytest.approx(1.0)
    assert average_precision([(boxes([*OTHER, 0.0]), boxes([*OTHER, 0.9]))]) == -1.0


def with_states(*states: str) -> Frame:
    """Return a hand-made frame with these states of the two cars."""
    episode = HandMadeEpisode()
    return next(f for f in (episode.step() for _ in range(FRAMES)) if tuple(f.truth.state) == states)


def test_visible_boxes_of_cars_in_the_picture_are_to_be_found() -> None:
    np.testing.assert_array_equal(cars_seen(with_states("in", "absent")), [[30, 20, 50, 32, 1]])
    np.testing.assert_array_equal(cars_seen(with_states("in", "out")), [[30, 20, 50, 32, 1]])
    np.testing.assert_array_equal(cars_seen(with_states("out", "in")), [[90, 60, 110, 72, 1]])


def test_cars_less_than_half_seen_do_not_count_and_hidden_ones_have_no_box() -> None:
    frame = with_states("in", "in")
    halves = replace(frame.truth, visible_fraction=np.array([0.49, 0.5]))
    np.testing.assert_array_equal(cars_seen(Frame(frame.observation, halves))[:, 4], [0, 1])
    instances = frame.truth.instance_map.copy()
    instances[:, :40] = -1
    instances[instances == 10] = -1
    hidden = replace(frame.truth, instance_map=instances)
    np.testing.assert_array_equal(cars_seen(Frame(frame.observation, hidden)), [[40, 20, 50, 32, 1]])


def test_parked_cars_are_to_be_found_too_and_lorries_and_people_are_no_cars(monkeypatch: pytest.MonkeyPatch) -> None:
    frame = with_states("in", "in")
    monkeypatch.setattr(type(frame.truth), "passing", ("person",))
    instances = frame.truth.instance_map.copy()
    instances[5:10, 5:15], instances[5:10, 45:48] = 20, 21
    parked = {"standing_kinds": ("van", "person"), "standing_id": np.array([20, 21])}
    truth = replace(frame.truth, kinds=("lorry", "sedan"), instance_map=instances, **parked)
    truth = replace(truth, standing_visible_fraction=np.array([0.4, 1.0]))
    np.testing.assert_array_equal(cars_seen(Frame(frame.observation, truth)), [[90, 60, 110, 72, 1], [5, 5, 15, 10, 0]])
