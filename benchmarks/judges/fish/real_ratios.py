"""Errors of gap methods on real tracks over those of the best simple method, from rows, with intervals over blocks."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from benchmarks.contract.rows import Row
from benchmarks.statistics.bootstrap import PooledRatios, bootstrap_interval

OURS = ("shoal_chain", "shoal_chain_shipped")
"""As it learns from what came before, and as shipped, which never learnt from the file."""
EXTRAPOLATION = ("fish_hold", "fish_constant_velocity", "fish_damped_velocity")
INTERPOLATION = ("fish_linear", "fish_hermite")
_LENGTHS: tuple[tuple[int, ...], ...] = ((50,), (100,), (200,), (50, 100), (50, 100, 200))


def real_ratios(rows: Sequence[Row]) -> Iterator[str]:
    """Yield a line for each of ``OURS``, each recording and each number of lost frames.

    Extrapolation: the error on the last lost frame over that of the simple method with the least. Interpolation: the
    mean error over the gap over that of the line and of the cubic. Over several lengths it is the geometric mean of
    the ratios at each, and the best is the method with the least geometric mean of errors.
    """
    for recording in sorted({str(row["preset"]) for row in rows}):
        mine = [row for row in rows if row["preset"] == recording]
        present = {str(row["tracker"]) for row in mine}
        for ours in (name for name in OURS if name in present):
            for lengths in _LENGTHS:
                rivals = {name: _ratio(mine, ours, name, "gap_error_{}_px", lengths) for name in EXTRAPOLATION}
                known = {name: each for name, each in rivals.items() if name in present}
                # Against the best method the ratio is the largest.
                if known and any(np.isfinite(each.mean) for each in known.values()):
                    best = max(known, key=lambda name: np.nan_to_num(known[name].mean))
                    yield _line(recording, ours, best, "extrapolation", lengths, known[best])
            for name in (each for each in INTERPOLATION if each in present):
                for lengths in _LENGTHS:
                    ratio = _ratio(mine, ours, name, "gap_interpolation_error_{}_px", lengths)
                    if np.isfinite(ratio.mean):
                        yield _line(recording, ours, name, "interpolation", lengths, ratio)


def _line(recording: str, ours: str, simple: str, kind: str, lengths: Sequence[int], ratio: PooledRatios) -> str:
    low, high = bootstrap_interval(ratio)
    frames = "+".join(map(str, lengths))
    return f"{recording}: {kind}, {frames} frames: {ours} / {simple} {ratio.mean:.3f} ({low:.3f} to {high:.3f})"


def _ratio(rows: Sequence[Row], first: str, second: str, metric: str, lengths: Sequence[int]) -> PooledRatios:
    names = {metric.format(length): column for column, length in enumerate(lengths)}
    used = [row for row in rows if row["metric"] in names and row["tracker"] in (first, second)]
    blocks = np.unique(np.array([int(row["seed"]) for row in used], dtype=np.int64))
    shape = (len(blocks), 2 * len(lengths))
    sums, counts = np.zeros(shape), np.zeros(shape)
    for row in used:
        column = names[row["metric"]] + (0 if row["tracker"] == first else len(lengths))
        place = np.searchsorted(blocks, int(row["seed"])), column
        sums[place] += row["value"] * row["weight"]
        counts[place] += row["weight"]

    def ratio(errors_px: NDArray[np.float64]) -> NDArray[np.float64]:
        logs = np.log(errors_px)
        return np.asarray(np.exp((logs[..., : len(lengths)] - logs[..., len(lengths) :]).mean(axis=-1)))

    return PooledRatios(blocks, sums, counts, ratio)
