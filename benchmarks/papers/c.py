"""Paper experiment C: lost pieces of a fish's track, predicted by a Kalman filter of constant acceleration.

Beside the table stand the paper's figures 1 to 4: trajectories with a lost piece, as it was and as it was predicted.
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from benchmarks.contract.rows import Row
from benchmarks.judges.fish.gap_protocol import PAST_FRAMES, BridgedGap, Gap, Tracks, bridge_gaps, turn_rad
from benchmarks.judges.fish.gap_scores import GAP_FRAMES, GapTask
from benchmarks.judges.fish.judge import FishJudge
from benchmarks.papers.experiment import Plots
from benchmarks.papers.tracker_experiment import TrackerExperiment
from benchmarks.run.episodes import simulated
from benchmarks.show.video import marks
from benchmarks.show.video.contact_sheet import picture_sheet
from scenarios import catalog
from scenarios.loop import Loop, tracker_stream
from scenarios.scenario import RendererName
from trackers import registry

_TURNING = "standard"
"""Preset of the turn, where the paper's own has none."""
_CELL_PX = 480
_MARGIN = 0.15
_LEAST_WINDOW_PX = 8.0
_STEP_FRAMES = 10
_LEAST_TURN_RAD = np.pi / 3
_LEAST_SPEED = 0.3
"""Of a fish that moves all the while, as a share of its median; fish that hover turn as they please."""
_COLOURS = (marks.ESTIMATE, marks.PARTICLE)


@dataclass(frozen=True, slots=True, kw_only=True)
class GapExperiment(TrackerExperiment):
    """See ``TrackerExperiment``. Figures 1 to 4 are trajectories; errors are shown as the suite's curves."""

    def show(self, out: Path, rows: Sequence[Row], seeds: range, renderer: RendererName) -> Plots:
        """See ``PaperExperiment``: the error over the length of the gap and over the change of heading."""
        self._show_paths(out, seeds.start, renderer)
        return self.suite_figures("Errors over the gap's length", rows, renderer)

    def _show_paths(self, out: Path, seed: int, renderer: RendererName) -> None:
        """Draw gaps of the paper's lengths with the median error, and one in which a fish turns while it moves."""
        written, ours = self.trackers
        tank = measured_tank(self.scenario, self.preset, seed, renderer)
        usual = [usual_gap(tank, count, written) for count in GAP_FRAMES]
        cells = [tank.cell(k, gap, self.trackers) for k, gap in enumerate(usual, 1) if gap is not None]
        turned = turning_gap(tank.task.tracks, tank.task.open_gaps)
        if turned is None:
            tank = measured_tank(self.scenario, _TURNING, seed, renderer)
            turned = turning_gap(tank.task.tracks, tank.task.open_gaps)
        if turned is not None:
            cells.append(tank.cell(len(GAP_FRAMES) + 1, turned, self.trackers))
        caption = (
            "White: the fish's track as measured in the 100 frames before the gap. Blue: where it truly was in the "
            f"gap. Orange: as {written} predicts it; yellow: as {ours} does, in that order above each picture, "
            f"which say how far off they end. Figures 1 to 3: of seed {seed} the gaps with the median error of "
            f"{written}. Figure 4: of the longest gaps the one over which a fish turns most while it moves; where "
            f"the slow fish only turns hovering, one of preset {_TURNING}. Each picture is enlarged about its path."
        )
        if cells:
            self.write_figure(out, picture_sheet([cells], 420), seed, renderer, "figures 1 to 4", caption, "paths")


@dataclass(frozen=True)
class Tank:
    """A measured episode.

    Attributes:
        preset, seed: which. floor_rgb: (H, W, 3) its first picture without fish. task: its gaps.
    """

    preset: str
    seed: int
    floor_rgb: NDArray[np.uint8]
    task: GapTask

    def bridged(self, tracker: str, gaps: Sequence[Gap]) -> list[BridgedGap]:
        """Return what a tracker's gap method predicts in the gaps, in their order of time."""
        method = registry.entry(tracker).create(tracker_stream(self.seed, tracker)).gap_method
        return bridge_gaps(method, self.task.tracks, gaps, both_ends=False, learns=True, mates=self.task.sees_mates)

    def cell(self, figure: int, gap: Gap, trackers: Sequence[str]) -> tuple[str, marks.Image]:
        """Return words and picture of a gap."""
        tracks, end = self.task.tracks, gap.first + gap.count
        past = tracks.position_px[gap.first - PAST_FRAMES : gap.first, gap.target]
        true = tracks.judged_px[gap.first - 1 : end, gap.target]
        shown = np.concatenate([past, true])
        low, high = np.nanmin(shown, axis=0), np.nanmax(shown, axis=0)
        side = max((1 + 2 * _MARGIN) * float((high - low).max()), _LEAST_WINDOW_PX)
        corner, zoom = 0.5 * (low + high) - 0.5 * side, _CELL_PX / side
        placed = np.array([[zoom, 0.0, -zoom * corner[0]], [0.0, zoom, -zoom * corner[1]]])
        picture = np.asarray(cv2.warpAffine(self.floor_rgb, placed, (_CELL_PX, _CELL_PX)), np.uint8)
        _draw(picture, zoom * (past - corner), marks.OBSERVED)
        _draw(picture, zoom * (true - corner), marks.TRUTH)
        words = []
        for tracker, colour in zip(trackers, _COLOURS, strict=False):
            (each,) = self.bridged(tracker, [gap])
            _draw(picture, zoom * (each.bridge.position_px - corner), colour)
            words.append(f"{each.measure('end'):.1f}")
        turn = f", turns {np.degrees(turn_rad(tracks, gap)):.0f}°" if figure > len(GAP_FRAMES) else ""
        return f"{figure}: {self.preset}, {gap.count} lost{turn}; {' and '.join(words)} px off", picture


def measured_tank(scenario: str, preset: str, seed: int, renderer: RendererName) -> Tank:
    """Return an episode as the suite's judge measures it."""
    with closing(simulated(scenario, preset, seed, renderer=renderer).open("all")) as episode:
        judge = FishJudge(episode, catalog.scenario(scenario))
        for frame in Loop(episode).frames():
            judge.see(frame, None)
        return Tank(preset, seed, episode.start.background[0].image_rgb, judge.task)


def usual_gap(tank: Tank, count: int, tracker: str) -> Gap | None:
    """Return the gap of so many frames with the median error of a tracker; None if there is none."""
    gaps = [gap for gap in tank.task.open_gaps if gap.count == count]
    ordered = sorted(tank.bridged(tracker, gaps), key=lambda each: each.measure("end"))
    return ordered[len(ordered) // 2].gap if ordered else None


def turning_gap(tracks: Tracks, gaps: Sequence[Gap]) -> Gap | None:
    """Return the gap of the longest ones over which a moving fish turns most, by 60° at least; None if there is none.

    It moves if it is never, over ten frames, slower than 0.3 times its median in the episode.
    """
    turns = {gap: turn_rad(tracks, gap) for gap in gaps if gap.count == GAP_FRAMES[-1] and _moves(tracks, gap)}
    turns = {gap: turn for gap, turn in turns.items() if turn >= _LEAST_TURN_RAD}
    return max(turns, key=lambda gap: turns[gap]) if turns else None


def _moves(tracks: Tracks, gap: Gap) -> bool:
    place = tracks.judged_px[:, gap.target]
    moved = np.linalg.norm(place[_STEP_FRAMES:] - place[:-_STEP_FRAMES], axis=1)
    meanwhile = moved[gap.first - _STEP_FRAMES - 1 : gap.first + gap.count]
    return bool((meanwhile >= _LEAST_SPEED * np.nanmedian(moved)).all())


def _draw(picture: marks.Image, path_px: NDArray[np.float64], colour: marks.Rgb) -> None:
    """Draw a path (T, 2) without what was not measured, and a dot at its end."""
    known = path_px[np.isfinite(path_px).all(axis=1)]
    if len(known):
        marks.draw_lines(picture, known[None], colour)
        cv2.circle(picture, marks.fixed_point(known[-1]).tolist(), 4 << 4, colour, cv2.FILLED, cv2.LINE_AA, 4)
