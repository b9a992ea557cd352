"""Paper experiment C: its claims are the paper's table, rows are held against them, and trajectories are drawn."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from benchmarks.contract.suite import suite
from benchmarks.judges.fish.gap_protocol import Gap, Tracks
from benchmarks.judges.fish.gap_scores import GapTask
from benchmarks.papers.c import GapExperiment, Tank, turning_gap, usual_gap
from benchmarks.papers.experiment import experiment_named, findings
from benchmarks.show.video import marks
from scenarios import catalog
from tests.benchmarks.papers.conftest import row
from trackers import registry

EXPERIMENT = experiment_named("C")
FRAMES = 420


def verdicts(errors_px: tuple[float, float, float]) -> dict[str, bool | None]:
    counts = (50, 100, 200)
    rows = [
        row(EXPERIMENT, "ca_kalman", f"gap_error_{count}_px", error)
        for count, error in zip(counts, errors_px, strict=True)
    ]
    return {each.claim.metric: each.agrees for each in findings(EXPERIMENT, rows) if each.claim.tracker == "ca_kalman"}


def test_it_names_what_exists() -> None:
    preset = catalog.scenario(EXPERIMENT.scenario).presets[EXPERIMENT.preset]
    assert not preset.closed_loop
    roles = {name: registry.entry(name).role for name in EXPERIMENT.trackers}
    assert list(roles.values()) == ["as-written", "ours"]
    assert all(EXPERIMENT.suite in registry.entry(name).suites for name in roles)
    for claim in EXPERIMENT.claims:
        assert suite(EXPERIMENT.suite).metric(claim.metric).unit in ("px", "1")
        assert claim.tracker in EXPERIMENT.trackers


def test_the_paper_s_own_numbers_agree_with_it() -> None:
    agreed = verdicts((0.60, 1.05, 2.81))
    assert agreed == dict.fromkeys(agreed, True)
    assert len(agreed) == 5


@pytest.mark.parametrize(
    ("errors_px", "disagree"),
    [
        ((0.61, 1.06, 2.82), set()),
        ((0.85, 1.05, 2.81), {"gap_error_50_px"}),
        ((0.60, 1.05, 4.00), {"gap_error_200_px", "gap_growth_200"}),
        # In another unit the growth is the same.
        ((6.0, 10.5, 28.1), {"gap_error_50_px", "gap_error_100_px", "gap_error_200_px"}),
    ],
)
def test_a_tolerance_of_forty_per_cent(errors_px: tuple[float, float, float], disagree: set[str]) -> None:
    agreed = verdicts(errors_px)
    assert {name for name, yes in agreed.items() if not yes} == disagree


@pytest.mark.parametrize(
    ("written_px", "ours_px", "agrees"),
    [
        # Episodes differ by more than the methods do: what counts is the difference on each.
        ((1.0, 5.0, 9.0, 13.0), (0.9, 4.8, 8.9, 12.8), True),
        ((1.0, 5.0, 9.0, 13.0), (0.9, 5.1, 8.9, 12.9), False),
        ((1.0, 5.0, 9.0, 13.0), (1.1, 5.2, 9.1, 13.2), False),
    ],
)
def test_ours_is_nearer_where_the_paired_interval_is_clear_of_zero(
    written_px: tuple[float, ...], ours_px: tuple[float, ...], agrees: bool
) -> None:
    named = {"ca_kalman": written_px, "shoal_chain": ours_px}
    rows = [
        row(EXPERIMENT, name, "gap_error_50_px", px, seed)
        for name, each in named.items()
        for seed, px in enumerate(each)
    ]
    (found,) = (
        each
        for each in findings(EXPERIMENT, rows)
        if each.claim.minus == "ca_kalman" and each.claim.metric == "gap_error_50_px"
    )
    assert found.mean == pytest.approx(sum(ours_px) / 4 - sum(written_px) / 4)
    assert (found.agrees, found.episodes, found.expected) == (agrees, 4, "interval below 0 px")


def test_ours_stands_beside_it_without_a_verdict_and_curves_are_drawn(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    # Trajectories are drawn from episodes.
    monkeypatch.setattr(GapExperiment, "_show_paths", lambda *_: None)
    rows = [row(EXPERIMENT, "shoal_chain", f"gap_error_{count}_px", 0.3) for count in (50, 100, 200)]
    found = [each for each in findings(EXPERIMENT, rows) if each.claim.tracker == "shoal_chain"]
    assert [(each.mean, each.agrees) for each in found if not each.claim.minus] == [(0.3, None)] * 3
    # Alone it has nothing to be compared with.
    assert [(each.mean, each.agrees) for each in found if each.claim.minus] == [(None, False)] * 3
    curves = [
        row(EXPERIMENT, name, "gap_error_by_frame_px", [0.1 * k for k in range(200)]) for name in EXPERIMENT.trackers
    ]
    plots = EXPERIMENT.show(tmp_path, [*rows, *curves], range(1), "raster")
    assert [heading.split("?")[0] for heading in plots.svgs] == ["How far off is a lost fish"]


def path(turn_at: int, turn_rad: float, pause: slice | None = None) -> NDArray[np.float64]:
    """Return the places (T, 2) of a fish that swims half a pixel a frame, turns once, and may pause."""
    heading = np.where(np.arange(FRAMES) < turn_at, 0.0, turn_rad)
    speed = np.full(FRAMES, 0.5)
    if pause is not None:
        speed[pause] = 0.0
    steps = speed[:, None] * np.column_stack([np.cos(heading), np.sin(heading)])
    return 100.0 + np.cumsum(steps, axis=0)


def tank(*paths: NDArray[np.float64]) -> Tank:
    places = np.stack(paths, axis=1)
    tracks = Tracks(places, 1 / 30, true_px=places)
    floor_rgb = np.full((320, 320, 3), 90, np.uint8)
    return Tank("paper-c", 0, floor_rgb, GapTask(tracks, 25, 450.0, sees_mates=True))


def turned(made: Tank) -> Gap | None:
    return turning_gap(made.task.tracks, made.task.open_gaps)


def test_the_gap_with_a_turn_is_of_the_fish_that_turns_most_while_it_moves() -> None:
    hovers, turns, straight = path(220, 3.0, slice(190, 250)), path(220, 1.6), path(220, 0.5)
    found = turned(tank(hovers, turns, straight))
    assert found is not None
    assert (found.target, found.count) == (1, 200)
    assert found.first < 220 < found.first + 200
    assert turned(tank(hovers, straight)) is None


def test_the_usual_gap_has_the_median_error() -> None:
    # The predictions of one that keeps the last place are off by as far as each fish swims.
    made = tank(*(path(0, 0.0) * np.array([scale, 1.0]) for scale in (1.0, 2.0, 3.0)))
    found = usual_gap(made, 50, "fish_hold")
    assert found is not None
    assert (found.target, found.count) == (1, 50)
    assert usual_gap(made, 60, "fish_hold") is None


@pytest.mark.parametrize(("figure", "turn_words"), [(3, ""), (4, ", turns 92°")])
def test_the_lost_piece_and_its_prediction_are_in_the_picture(figure: int, turn_words: str) -> None:
    words, picture = tank(path(220, 1.6)).cell(figure, Gap(0, 150, 200), ("fish_hold",))
    # 70 frames ahead, 130 across.
    off_px = 0.5 * np.hypot(*(70 * np.array([1, 0]) + 130 * np.array([np.cos(1.6), np.sin(1.6)])))
    assert words == f"{figure}: paper-c, 200 lost{turn_words}; {off_px:.1f} px off"
    for colour in (marks.OBSERVED, marks.TRUTH, marks.ESTIMATE):
        assert (picture == colour).all(axis=2).sum() > 20
