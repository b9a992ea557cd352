"""Time seen, time in view and losses: cases made by hand, and properties of all cases."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from benchmarks.judges.view_time import Loss, find_losses, view_scores
from tests.benchmarks.hand_made import IN_VIEW_OR_NOT, view

RATE_HZ = 10.0


def scores(in_view: np.ndarray) -> dict[str, float]:
    found = view_scores(in_view, np.ones(len(in_view)), RATE_HZ)
    return {score.metric: score.value for score in found}


def test_a_loss_lasts_longer_than_a_second() -> None:
    in_view = view((True, 5), (False, 10), (True, 3), (False, 11), (True, 2), (False, 30))
    first, second = find_losses(in_view, RATE_HZ)
    assert first == Loss(index=0, first_frame=18, length_frames=11, back_frame=29)
    assert second == Loss(index=1, first_frame=31, length_frames=30, back_frame=None)
    assert first.attributes() == {
        "kind": "loss",
        "index": 0,
        "first_frame": 18,
        "length_frames": 11,
        "back_frame": 29,
    }
    # 60 steps are six seconds.
    assert scores(in_view) == pytest.approx({"time_seen": 9 / 60, "time_in_view": 9 / 60, "losses_per_minute": 20.0})


def test_a_share_is_of_steps_alone() -> None:
    assert scores(view((True, 1), (True, 3), (False, 1)))["time_in_view"] == 0.75
    assert scores(view((True, 1), (False, 4)))["time_in_view"] == 0.0


@given(IN_VIEW_OR_NOT)
def test_losses_are_apart_and_out_of_view(in_view: np.ndarray) -> None:
    losses = find_losses(in_view, RATE_HZ)
    covered = np.zeros(len(in_view), dtype=int)
    for loss in losses:
        end = loss.first_frame + loss.length_frames
        covered[loss.first_frame : end] += 1
        assert loss.back_frame in (None, end)
        assert (loss.back_frame is None) == (end == len(in_view))
    assert covered.max() <= 1
    assert not (covered.astype(bool) & in_view).any()
    assert covered.sum() <= (~in_view[1:]).sum()


def test_a_target_behind_a_wall_is_in_view_and_not_seen() -> None:
    in_view = view((True, 6), (False, 5))
    visible = np.array([1.0, 1.0, 0.5, 0.49, 0.0, 0.0, *[1.0] * 5])
    found = {score.metric: (score.value, score.weight) for score in view_scores(in_view, visible, RATE_HZ)}
    assert found == {"time_seen": (0.2, 10.0), "time_in_view": (0.5, 10.0), "losses_per_minute": (0.0, 10.0)}


@given(IN_VIEW_OR_NOT, st.data())
def test_it_is_never_seen_for_longer_than_in_view(in_view: np.ndarray, data: st.DataObject) -> None:
    shares = st.lists(st.floats(0, 1), min_size=len(in_view), max_size=len(in_view))
    found = {score.metric: score.value for score in view_scores(in_view, np.array(data.draw(shares)), RATE_HZ)}
    assert found["time_seen"] <= found["time_in_view"]
