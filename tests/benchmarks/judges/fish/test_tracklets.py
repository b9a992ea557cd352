"""Pieces of real tracks are linked by predictions alone."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.judges.fish.gap_protocol import Tracks
from benchmarks.judges.fish.links import Outcome
from benchmarks.judges.fish.tracklets import Tracklet, find_tracklets, link_tracklets
from benchmarks.run.guards import Guard, GuardedGapMethod
from tests.benchmarks.judges.fish.gap_methods import Fails, GivesUp, Knows, swimming

TRUE_PX = swimming(600, 4)
MEASURED = TRUE_PX.copy()
MEASURED[200:230, 0] = np.nan
MEASURED[210:240, 1] = np.nan
MEASURED[400:403, 2] = np.nan


def test_pieces_end_at_gaps_and_jumps_and_short_ones_are_left_out() -> None:
    jumped = MEASURED[:, :3].copy()
    jumped[303:, 2] += 90.0
    jumped[306:, 2] += 90.0
    found = find_tracklets(Tracks(jumped, 1 / 30))
    spans = [(each.animal, each.first, each.end) for each in found]
    assert spans == [(0, 0, 200), (1, 0, 210), (2, 0, 303), (2, 306, 400), (0, 230, 600), (1, 240, 600), (2, 403, 600)]
    assert found[0] == Tracklet(0, 0, 200)


def test_a_method_that_knows_links_all_and_is_sure() -> None:
    links = link_tracklets(lambda: Knows(TRUE_PX, deviation_px=2.0), Tracks(MEASURED, 1 / 30))
    assert [(link.gap.fish, link.gap.first_frame, link.gap.length_frames) for link in links] == [
        (0, 200, 30),
        (1, 210, 30),
        (2, 400, 3),
    ]
    assert [link.outcome for link in links] == [Outcome.RIGHT] * 3
    assert [link.gap.fish_count for link in links] == [2, 1, 1]
    assert min(link.confidence for link in links) > 0.99


def test_one_that_takes_each_for_the_other_is_wrong() -> None:
    swapped = TRUE_PX.copy()
    swapped[201:, [0, 1]] = swapped[201:, [1, 0]]
    away = Knows(swapped, deviation_px=2.0)
    links = link_tracklets(lambda: away, Tracks(MEASURED, 1 / 30))
    assert links[0].outcome == Outcome.WRONG


def test_one_that_predicts_far_off_makes_no_link() -> None:
    links = link_tracklets(lambda: Knows(TRUE_PX, off_px=2000.0, deviation_px=2.0), Tracks(MEASURED, 1 / 30))
    assert [link.outcome for link in links] == [Outcome.ABSTAINED] * 3
    assert np.isnan([link.confidence for link in links]).all()


def test_one_without_covariance_links_nothing() -> None:
    assert link_tracklets(lambda: Knows(TRUE_PX, deviation_px=None), Tracks(MEASURED, 1 / 30)) == []


def test_no_link_is_judged_across_a_jump_alone() -> None:
    """The file's own identity is most in doubt where an animal jumps."""
    jumped = MEASURED.copy()
    jumped[300:, 3] += 90.0
    tracks = Tracks(jumped, 1 / 30)
    assert [(each.first, each.end) for each in find_tracklets(tracks) if each.animal == 3] == [
        (0, 300),
        (300, 600),
    ]
    links = link_tracklets(lambda: Knows(jumped, deviation_px=2.0), tracks)
    assert [(link.gap.fish, link.gap.length_frames) for link in links] == [(0, 30), (1, 30), (2, 3)]


def test_a_piece_that_a_method_gives_up_on_is_not_linked() -> None:
    tracks = Tracks(MEASURED, 1 / 30)
    links = link_tracklets(lambda: GivesUp(TRUE_PX, {1}, deviation_px=2.0), tracks)
    assert [link.outcome.name for link in links] == ["RIGHT", "ABSTAINED", "RIGHT"]
    # One that returns None for the first does not extrapolate at all.
    assert link_tracklets(lambda: GivesUp(TRUE_PX, {0}, deviation_px=2.0), tracks) == []


def test_a_method_that_fails_makes_no_link_from_there_on() -> None:
    guard = Guard(60.0)
    links = link_tracklets(lambda: GuardedGapMethod(Fails(), guard, 0), Tracks(MEASURED, 1 / 30))
    assert guard.reason == "RuntimeError: it fails"
    assert [link.outcome for link in links] == [Outcome.ABSTAINED] * 3


def test_it_learns_from_what_was_before_each_end() -> None:
    method = Knows(TRUE_PX)
    link_tracklets(lambda: method, Tracks(MEASURED, 1 / 30))
    assert method.lessons == [500]


def test_one_animal_is_linked_too() -> None:
    tracks = Tracks(MEASURED[:, :1], 1 / 30)
    (link,) = link_tracklets(lambda: Knows(TRUE_PX[:, :1]), tracks)
    assert link.outcome == Outcome.RIGHT
    assert link.gap.fish_count == 1
    assert link.confidence == pytest.approx(1.0, abs=1e-2)
