"""Gaps cut out of tracks: which, what a method may see of them, and the errors of known answers."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest

from benchmarks.judges.fish.gap_protocol import (
    BLOCK_FRAMES,
    PAST_FRAMES,
    Gap,
    Tracks,
    bridge_gaps,
    cut_gaps,
    turn_rad,
)
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
    gaps = cut_gaps(tracks, (20,), stride=1, jump_px=40.0)
    for target, broken in ((0, 200), (1, 250)):
        firsts = {gap.first for gap in gaps if gap.target == target}
        # The jump is the step to its frame; the hole also the step away from it.
        after = broken + PAST_FRAMES + (target == 0)
        assert firsts == {*range(PAST_FRAMES, broken - 19), *range(after, 381)}
    assert {gap.first for gap in cut_gaps(still(400), (20,), stride=1, jump_px=1.0, both_ends=True)} == {
        *range(PAST_FRAMES, 400 - 20 - PAST_FRAMES + 1)
    }


def test_a_method_learns_from_whole_blocks_before_the_gap_alone() -> None:
    tracks, method = still(), Shifted()
    tracks.position_px[700:, 0, 0] -= 5.0
    gaps = cut_gaps(tracks, (50,), stride=50, jump_px=10.0)
    bridge_gaps(method, tracks, gaps, both_ends=False, learns=True, mates=False)
    assert method.learnt_to == [BLOCK_FRAMES, 2 * BLOCK_FRAMES]
    assert set(method.mates) == {0}
    for gap, bounds in zip(gaps, method.bounds, strict=True):
        np.testing.assert_array_equal(bounds, [0.0 if gap.first <= 700 else -5.0, 0.0, 30.0, 40.0])
    seeing = Shifted()
    bridge_gaps(seeing, tracks, gaps, both_ends=False, learns=False, mates=True)
    assert seeing.learnt_to == []
    assert set(seeing.mates) == {1}


def test_errors_and_regions_of_known_answers() -> None:
    tracks = still()
    gaps = cut_gaps(tracks, (50, 100), stride=50, jump_px=10.0)
    for shift_px, sigma_px, inside in ((3.0, 1.0, False), (4.0, 2.0, True)):
        method = Shifted(shift_px, sigma_px)
        bridged = bridge_gaps(method, tracks, gaps, both_ends=False, learns=False, mates=False)
        assert [each.gap for each in bridged] == gaps
        for each in bridged:
            assert (each.measure("end"), each.measure("mean")) == pytest.approx((shift_px, shift_px))
            # 95 % of a round Gaussian lie within 2.45 standard deviations.
            assert each.inside is not None
            assert set(each.inside) == {inside}
    assert bridge_gaps(Shifted(), tracks, gaps, both_ends=True, learns=False, mates=False) == []


def test_the_turn_over_a_gap() -> None:
    x = np.zeros((400, 1, 2))
    x[:200, 0, 0] = np.arange(200)
    x[200:, 0] = [199.0, 0.0] + np.arange(200)[:, None] * np.array([0.0, 1.0])
    assert turn_rad(Tracks(x, 1.0), Gap(0, 150, 100)) == pytest.approx(np.pi / 2)
    assert np.isnan(turn_rad(Tracks(x, 1.0), Gap(0, 300, 100)))


@pytest.mark.parametrize(("name", "how"), [("counts", {"counts": ()}), ("stride", {"stride": 0})])
def test_impossible_cuts_are_named(name: str, how: dict[str, object]) -> None:
    with pytest.raises(ValueError, match=f"{name}: expected"):
        cut_gaps(still(), **({"counts": (5,), "stride": 5, "jump_px": 1.0} | how))
