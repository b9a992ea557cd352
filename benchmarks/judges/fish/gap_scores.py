"""Scores of a method that bridges gaps: those of the paper's protocol, and the choice of a lost piece's successor."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from benchmarks.contract.judging import Score
from benchmarks.judges.fish.gap_protocol import BridgedGap, Gap, Measure, Tracks, bridge_gaps, cut_gaps, turn_rad
from sim.rng import generator
from trackers.gaps import GapMethod

GAP_FRAMES = (50, 100, 200)
"""Numbers of lost frames, those of the paper."""
TURNS_DEG = (0, 30, 60, 90, 120, 150)
"""Lower ends of the classes of the change of heading in a gap; each is 30 degrees wide."""
_TURN_WIDTH_DEG = 30
_USUAL_STEP_QUANTILE, _JUMP = 0.99, 3.0
"""A step that is so many times as long as the longest usual one is a jump, which breaks a track."""


@dataclass(frozen=True)
class GapTask:
    """The gaps of one recording.

    Attributes:
        tracks: as measured.
        stride: frames from one gap of a fish to its next of the same length.
        cap_px: error of a prediction that failed; the diagonal of the picture.
        sees_mates: whether methods see the other fish's tracks.
    """

    tracks: Tracks
    stride: int
    cap_px: float
    sees_mates: bool

    @cached_property
    def jump_px(self) -> float:
        """Length of a step from which on it breaks a track; NaN, which no step is below, without any step."""
        step_px = np.linalg.norm(np.diff(self.tracks.position_px, axis=0), axis=-1)
        known = step_px[np.isfinite(step_px)]
        return _JUMP * float(np.quantile(known, _USUAL_STEP_QUANTILE)) if len(known) else float("nan")

    @cached_property
    def open_gaps(self) -> list[Gap]:
        """Gaps whose far end is unknown."""
        return cut_gaps(self.tracks, GAP_FRAMES, stride=self.stride, jump_px=self.jump_px)

    @cached_property
    def closed_gaps(self) -> list[Gap]:
        """Gaps whose far end is known."""
        return cut_gaps(self.tracks, GAP_FRAMES, stride=self.stride, jump_px=self.jump_px, both_ends=True)

    def bridged(self, new_method: Callable[[], GapMethod]) -> Bridged:
        """Return what a method makes of all gaps; a fresh copy of it bridges each kind."""
        how = {"learns": True, "mates": self.sees_mates}
        return Bridged(
            self._capped(bridge_gaps(new_method(), self.tracks, self.open_gaps, both_ends=False, **how)),
            self._capped(bridge_gaps(new_method(), self.tracks, self.closed_gaps, both_ends=True, **how)),
        )

    def _capped(self, bridged: Sequence[BridgedGap]) -> list[BridgedGap]:
        return [replace(each, error_px=np.nan_to_num(each.error_px, nan=self.cap_px)) for each in bridged]


@dataclass(frozen=True)
class Bridged:
    """Gaps of one recording as a method bridged them.

    Attributes:
        extrapolated: the far end unknown. interpolated: known. Empty where the method does not.
    """

    extrapolated: list[BridgedGap]
    interpolated: list[BridgedGap]

    def by_block(self) -> dict[int, Bridged]:
        """Return the gaps of each block of time, by its number in order."""
        blocks: dict[int, Bridged] = defaultdict(lambda: Bridged([], []))
        for each in self.extrapolated:
            blocks[each.block].extrapolated.append(each)
        for each in self.interpolated:
            blocks[each.block].interpolated.append(each)
        return dict(sorted(blocks.items()))


def gap_scores(tracks: Tracks, bridged: Bridged) -> Iterator[Score]:
    """Yield the scores of a method on the gaps of G = 50, 100 and 200 lost frames that it bridged.

    ``gap_error_G_px``: mean distance of the prediction for the last lost frame to the true place, or to the measured
    one where that is unknown. ``gap_interpolation_error_G_px``: far end known, mean over the gap.
    ``gap_coverage_G``, ``gap_interpolation_coverage_G``: share of these places, and of those of all lost frames, inside
    the method's 95 % region. ``successor_rate_G``: see ``successors``. ``gap_error_by_frame_px`` (*series* over the
    frames of the longest gaps), ``gap_error_G_turn_D_px``: the first by change of heading, from D to D + 30 degrees.
    """
    for count in GAP_FRAMES:
        ends = [each for each in bridged.extrapolated if each.gap.count == count]
        yield from _mean(f"gap_error_{count}_px", ends, "end")
        yield from _coverage(f"gap_coverage_{count}", ends, "end")
        chosen = [right for group in _at_once(ends) for right in successors(tracks, group)]
        if chosen:
            yield Score(f"successor_rate_{count}", float(np.mean(chosen)), float(len(chosen)))
        turns_deg = np.array([np.degrees(turn_rad(tracks, each.gap)) for each in ends])
        for low in TURNS_DEG:
            # The last class holds half a turn.
            high = low + _TURN_WIDTH_DEG + (low == TURNS_DEG[-1])
            some = [each for each, turn in zip(ends, turns_deg, strict=True) if low <= turn < high]
            yield from _mean(f"gap_error_{count}_turn_{low}_px", some, "end")
        between = [each for each in bridged.interpolated if each.gap.count == count]
        yield from _mean(f"gap_interpolation_error_{count}_px", between, "mean")
        yield from _coverage(f"gap_interpolation_coverage_{count}", between, "mean")
    longest = [each.error_px for each in bridged.extrapolated if each.gap.count == GAP_FRAMES[-1]]
    if longest:
        yield Score("gap_error_by_frame_px", np.mean(longest, axis=0).tolist(), float(len(longest)))


def successors(tracks: Tracks, lost: Sequence[BridgedGap]) -> list[bool]:
    """Return whether each of several fish that are lost at once is told which place on the last lost frame is its own.

    The places are given to the fish so that the sum of ``d' C^-1 d + log det C`` is least, d the distance to the
    prediction and C its covariance; so that the sum of squared distances is, where a method gives none. Of several
    such choices one is taken at random. A fish without a prediction is told none.
    """
    end = lost[0].gap.first + lost[0].gap.count - 1
    places = np.array([tracks.judged_px[end, each.gap.target] for each in lost])
    cost = np.array([_misfit(each, places) for each in lost])
    told = np.isfinite(cost).all(axis=1)
    chosen = assigned(np.where(told[:, None], cost, 0.0), generator(lost[0].gap.first, "successors"))
    return [bool(known) and column == row for row, (column, known) in enumerate(zip(chosen, told, strict=True))]


def assigned(cost: NDArray[np.float64], rng: np.random.Generator) -> list[int]:
    """Return the column for each row (R,) of least cost in all, of R x C with R <= C; a random one of several such.

    Without the shuffling of columns ties would go to the order of the columns, which may be that of the truth.
    """
    order = rng.permutation(cost.shape[1])
    return [int(order[column]) for column in linear_sum_assignment(cost[:, order])[1]]


def _misfit(lost: BridgedGap, places: NDArray[np.float64]) -> NDArray[np.float64]:
    away_px = places - lost.bridge.position_px[-1]
    if lost.bridge.covariance_px is None:
        return np.asarray((away_px**2).sum(axis=1))
    covariance = lost.bridge.covariance_px[-1]
    _, log_det = np.linalg.slogdet(covariance)
    return np.asarray((away_px * np.linalg.solve(covariance, away_px.T).T).sum(axis=1) + log_det)


def _at_once(bridged: Sequence[BridgedGap]) -> list[list[BridgedGap]]:
    """Return the gaps that begin together, where there are several."""
    groups: dict[int, list[BridgedGap]] = defaultdict(list)
    for each in bridged:
        groups[each.gap.first].append(each)
    return [group for group in groups.values() if len(group) > 1]


def _mean(name: str, bridged: Sequence[BridgedGap], measure: Measure) -> Iterator[Score]:
    if bridged:
        yield Score(name, float(np.mean([each.measure(measure) for each in bridged])), float(len(bridged)))


def _coverage(name: str, bridged: Sequence[BridgedGap], measure: Measure) -> Iterator[Score]:
    regions = [each.inside for each in bridged if each.inside is not None]
    if regions:
        inside = [region[-1] if measure == "end" else region.mean() for region in regions]
        yield Score(name, float(np.mean(inside)), float(len(inside)))
