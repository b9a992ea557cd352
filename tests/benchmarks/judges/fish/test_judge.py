"""The judge of the suite ``fish`` on an episode drawn by hand: two fish that cross, and one that swims alone."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest

from benchmarks.contract.judging import Ending
from benchmarks.judges.fish.judge import AT_ONCE, FishJudge
from scenarios.fish_tank.truth import FishTruth
from tests.benchmarks.judges.fish.gap_methods import Knows
from tests.benchmarks.judges.fish.hand_made import CAMERA, LENGTH_PX, empty_pictures, frame_of, track, truth_of
from trackers.gaps import GapMethod
from trackers.types import Start, Track

FRAMES = 240
CROSSED = 190
"""Two fish meet here."""


@dataclass
class DrawnEpisode:
    """What the judge asks of an episode."""

    start: Start
    rate_hz: float = 30.0


def truths() -> list[FishTruth]:
    made = []
    for k in range(FRAMES):
        across = 0.6 * (k - CROSSED)
        places = [(60 + across, 30 + 0.3 * across), (60 - across, 30), (20 + 0.3 * k, 65)]
        made.append(truth_of(places, [np.arctan(0.3), np.pi, 0.0], frame=k))
    return made


TRUTHS = truths()
TRUE_PX = np.array([truth.position_px for truth in TRUTHS])
PERFECT = [[track(k, truth.position_px[k], 0.9) for k in range(3)] for truth in TRUTHS]
SWAPPED = [
    tracks if k < CROSSED else [Track((1, 0, 2)[each.identity], each.estimate, confidence=0.9) for each in tracks]
    for k, tracks in enumerate(PERFECT)
]


@pytest.fixture(scope="module")
def judge() -> FishJudge:
    episode: Any = DrawnEpisode(Start(CAMERA, background=empty_pictures(20)))
    made = FishJudge(episode, None)  # type: ignore[arg-type]
    for truth in TRUTHS:
        made.see(frame_of(truth), None)
    return made


def scored(judge: FishJudge, answers: Sequence[Sequence[Track]], ending: Ending | None = None) -> dict[str, Any]:
    sheet = judge.sheet()
    for truth, tracks in zip(TRUTHS, answers, strict=True):
        sheet.keep(frame_of(truth), tracks)
    return {each.metric: each.value for each in sheet.scores(ending or Ending()) if each.event is None}


def test_bodies_are_measured_in_the_picture(judge: FishJudge) -> None:
    assert judge.length_px == pytest.approx(LENGTH_PX)
    tracks = judge.task.tracks
    apart = judge.fish.apart
    seen = np.isfinite(tracks.position_px[..., 0])
    # Nothing is measured where fish touch, and most of what stands apart inside the picture is.
    assert not (seen & ~apart).any()
    assert seen[100:, 2].mean() > 0.9
    error_px = np.linalg.norm(tracks.position_px - TRUE_PX, axis=2)
    assert np.nanmax(error_px) < 3.0
    assert tracks.heading_rad is not None
    line = tracks.heading_rad[:, 2][seen[:, 2]]
    # Head and tail of these bodies look the same, but along a run they stay where they are.
    assert np.abs(np.sin(line)).max() < 0.3
    assert len(np.unique(np.sign(np.cos(line)))) <= 1 + int((~seen[:, 2]).any())


def test_the_two_that_cross_have_a_gap_each(judge: FishJudge) -> None:
    assert [(gap.fish, gap.crosses, gap.fish_count) for gap in judge.gaps] == [(0, True, 2), (1, True, 2)]
    assert all(gap.first_frame < CROSSED < gap.end_frame for gap in judge.gaps)


def test_a_perfect_tracker(judge: FishJudge) -> None:
    scores = scored(judge, PERFECT)
    inside = np.isfinite(judge.fish.position_px[..., 0])
    # Fish that swim out of the picture are no targets there; tracks on them are false.
    assert scores["false_rate"] == pytest.approx((~inside).sum() / inside.sum())
    assert (scores["identity_switches"], scores["missed_rate"]) == (0.0, 0.0)
    assert (scores["link_precision_crossing_50"], scores["link_rate_50"]) == (1.0, 1.0)
    assert scores["identity_runs_2"][-1] == 2.0
    # It revises nothing, so that all it says is said at once.
    at_once = {name: value for name, value in scores.items() if name.endswith(AT_ONCE)}
    assert {"hota_at_once", "identity_right_frames_at_once", "link_precision_50_at_once"} <= set(at_once)
    assert at_once == {name: scores[name.removesuffix(AT_ONCE)] for name in at_once}
    assert not [name for name in scores if name.startswith("gap_error")]


def test_a_swap_is_two_wrong_links(judge: FishJudge) -> None:
    scores = scored(judge, SWAPPED)
    assert scores["link_precision_50"] == 0.0
    assert scores["identity_switches"] == 2.0
    assert scores["hota"] < scored(judge, PERFECT)["hota"]


def test_revised_answers_count_and_the_immediate_ones_are_kept(judge: FishJudge) -> None:
    scores = scored(judge, SWAPPED, Ending(revised=PERFECT))
    assert scores["link_precision_50"] == 1.0
    assert scores["link_precision_50_at_once"] == 0.0
    assert scores["hota"] == scored(judge, PERFECT)["hota"]
    assert scores["hota_at_once"] == scored(judge, SWAPPED)["hota"]


def test_a_gap_method_alone_has_no_scores_of_tracks(judge: FishJudge) -> None:
    nothing: list[list[Track]] = [[]] * FRAMES

    def knows() -> GapMethod:
        return Knows(TRUE_PX, off_px=2.0, deviation_px=1.0)

    scores = scored(judge, nothing, Ending(new_gap_method=knows))
    assert scores["gap_error_50_px"] == pytest.approx(2.0)
    assert "hota" not in scores
    # One that answers with hindsight alone does follow fish.
    late = scored(judge, nothing, Ending(revised=PERFECT, new_gap_method=knows))
    assert (late["hota"], late["hota_at_once"]) == (scored(judge, PERFECT)["hota"], 0.0)
    # One that failed, and one that offers nothing else, are judged by their silence.
    for ending in (Ending(failed_at_frame=0, new_gap_method=knows), Ending()):
        scores = scored(judge, nothing, ending)
        assert (scores["hota"], scores["link_rate_50"], scores["missed_rate"]) == (0.0, 0.0, 1.0)
