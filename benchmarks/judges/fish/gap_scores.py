"""Scores of a method that bridges gaps: those of the paper's protocol, and the choice of a lost piece's successor."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from benchmarks.contract.judging import Score
from benchmarks.judges.fish.gap_protocol import GAP_FRAMES, Bridged, BridgedGap, Tracks, squared_distance
from sim.rng import generator


def gap_scores(tracks: Tracks, bridged: Bridged) -> Iterator[Score]:
    """Yield the scores of a method on the gaps of G = 50, 100 and 200 lost frames that it bridged.

    ``gap_error_G_px``: mean distance of the prediction for the last lost frame to the true place, or to the measured
    one where that is unknown. ``gap_interpolation_error_G_px``: far end known, mean over the gap.
    ``gap_coverage_G``, ``gap_interpolation_coverage_G``: share of these places, and of those of all lost frames, inside
    the method's 95 % region. ``successor_rate_G``: see ``successors``. ``gap_error_by_frame_px`` (*series* over the
    frames of the longest gaps).
    """
    for count in GAP_FRAMES:
        ends = [each for each in bridged.extrapolated if each.gap.count == count]
        at_once: dict[int, list[BridgedGap]] = defaultdict(list)
        for each in ends:
            at_once[each.gap.first].append(each)
        several = (group for group in at_once.values() if len(group) > 1)
        yield from _mean(f"gap_error_{count}_px", [each.error_px[-1] for each in ends])
        yield from _mean(f"gap_coverage_{count}", [each.inside[-1] for each in ends if each.inside is not None])
        yield from _mean(f"successor_rate_{count}", [right for lost in several for right in successors(tracks, lost)])
        whole = [each for each in bridged.interpolated if each.gap.count == count]
        yield from _mean(f"gap_interpolation_error_{count}_px", [each.error_px.mean() for each in whole])
        inside = [each.inside.mean() for each in whole if each.inside is not None]
        yield from _mean(f"gap_interpolation_coverage_{count}", inside)
    longest = [each.error_px for each in bridged.extrapolated if each.gap.count == GAP_FRAMES[-1]]
    if longest:
        yield Score("gap_error_by_frame_px", np.mean(longest, axis=0).tolist(), float(len(longest)))


def _mean(name: str, values: Sequence[Any]) -> Iterator[Score]:
    if values:
        yield Score(name, float(np.mean(values)), float(len(values)))


def successors(tracks: Tracks, lost: Sequence[BridgedGap]) -> list[bool]:
    """Return whether each of several fish that are lost at once is given its own place on the last lost frame.

    The places are given to the fish so that the sum of ``d' C^-1 d + log det C`` is least, d the distance to the
    prediction and C its covariance; so that the sum of squared distances is, where a method gives none. Of several
    such choices one is taken at random. A fish without a prediction is given none.
    """
    places = np.array([tracks.judged_px[each.gap.end - 1, each.gap.target] for each in lost])
    cost = np.array([_misfit(each, places) for each in lost])
    predicted = np.isfinite(cost).all(axis=1)
    chosen = assigned(np.where(predicted[:, None], cost, 0.0), generator(lost[0].gap.first, "successors"))
    return [bool(known) and column == row for row, (column, known) in enumerate(zip(chosen, predicted, strict=True))]


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
    covariance = np.broadcast_to(lost.bridge.covariance_px[-1], (len(places), 2, 2))
    return squared_distance(away_px, covariance) + np.linalg.slogdet(covariance)[1]
