"""Gaps cut out of tracks: which, what a method may see of them, and the errors of known answers."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest

from benchmarks.judges.fish.gap_protocol import BLOCK_FRAMES, PAST_FRAMES, GapTask, Tracks, cut_gaps
from trackers.gaps import Bridge, Piece, Surroundings


class Shifted:
    """Holds the last position, moved to the right, and writes down what it was shown."""

    def __init__(self, shift_px: float = 0.0, sigma_px: float = 1e6) -> None:
        self._shift_px, self._sigma_px = shift_px, sigma_px
        self.learnt_to: list[int] = []
        self.mates: list[int] = []
        self.bounds: list[np.ndarray] = []

    def learn(self, pieces: Sequence[Piece]) -> None:
        self.learnt_to.append(max(piece.end_frame for piece in pieces))

    def extrapolate(self, past: Piece, count: int, around: Surroundings) -> Bridge:
        assert past.end_frame >= self.learnt_to[-1] if self.learnt_to else True
        assert len(past.position_px) == PAST_FRAMES
        self.mates.append(len(around.mates))
        self.bounds.append(around.bounds_xyxy)
        place = past.position_px[-1] + [self._shift_px, 0.0]
        return Bridge(np.tile(place, (count, 1)), np.tile(self._sigma_px**2 * np.eye(2), (count, 1, 1)))

    def interpolate(self, past: Piece, future: Piece, around: Surroundings) -> None:
        return None


def still(frames: int = 1200, count: int = 2) -> Tracks:
    x = np.zeros((frames, count, 2))
    x[:, 1] = [30.0, 40.0]
    return Tracks(x, 1 / 30)


def test_windows_with_a_hole_or_a_jump_are_left_out() -> None:
    tracks = still(400)
    tracks.position_px[200, 0] = np.nan
    tracks.position_px[250:, 1] += 50.0
    gaps = cut_gaps(tracks, 1, (20,))
    for target, broken in ((0, 200), (1, 250)):
        firsts = {gap.first for gap in gaps if gap.target == target}
        # The jump is the step to its frame; the hole also the step away from it.
        after = broken + PAST_FRAMES + (target == 0)
        assert firsts == {*range(PAST_FRAMES, broken - 19), *range(after, 381)}
    closed = {gap.first for gap in cut_gaps(still(400), 1, (20,), both_ends=True)}
    assert closed == {*range(PAST_FRAMES, 400 - 20 - PAST_FRAMES + 1)}


@pytest.mark.parametrize("sees_mates", [False, True])
def test_a_method_learns_from_whole_blocks_before_the_gap_alone(sees_mates: bool) -> None:
    tracks, method = still(), Shifted()
    tracks.position_px[700:, 0, 0] -= 5.0
    task = GapTask(tracks, 50, 500.0, sees_mates)
    task.bridged(lambda: method)
    assert method.learnt_to[:2] == [BLOCK_FRAMES, 2 * BLOCK_FRAMES]
    assert set(method.mates) == {int(sees_mates)}
    for gap, bounds in zip(task.open_gaps, method.bounds, strict=True):
        np.testing.assert_array_equal(bounds, [0.0 if gap.first <= 700 else -5.0, 0.0, 30.0, 40.0])


@pytest.mark.parametrize(("shift_px", "sigma_px", "inside"), [(3.0, 1.0, False), (4.0, 2.0, True)])
def test_errors_and_regions_of_known_answers(shift_px: float, sigma_px: float, inside: bool) -> None:
    task = GapTask(still(), 50, 500.0, sees_mates=False)
    bridged = task.bridged(lambda: Shifted(shift_px, sigma_px))
    assert [each.gap for each in bridged.extrapolated] == task.open_gaps
    for each in bridged.extrapolated:
        assert each.error_px == pytest.approx(np.full(each.gap.count, shift_px))
        # 95 % of a round Gaussian lie within 2.45 standard deviations.
        assert each.inside is not None
        assert set(each.inside) == {inside}
    assert bridged.interpolated == []


def test_an_impossible_stride_is_named() -> None:
    with pytest.raises(ValueError, match="stride: expected"):
        cut_gaps(still(), 0)
