"""What a tracker would find by chance: its tracks on nothing beside the truth of another time."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from benchmarks.judges.harbour.history import History
from benchmarks.judges.harbour.matching import RADIUS_M, overlaps_of
from benchmarks.judges.harbour.streaks import highest, streaks

DRAWS = 20
"""Times that the truth is shifted."""


def chance_levels(
    history: History,
    judged: NDArray[np.bool_],
    place_m: NDArray[np.float64],
    box_xyxy: NDArray[np.float64],
    rng: np.random.Generator,
) -> NDArray[np.float64]:
    """Return (``DRAWS``, N) the highest threshold at which each intruder is found four frames running by tracks that
    have nothing to do with it, -inf where it is not.

    These tracks are the identities that lie on nothing more often than not. The truth is shifted in time against them
    by a random number of frames, round the end of the episode.

    Args:
        judged: (T, N). place_m: (T, N, 2) over the ground. box_xyxy: (T, N, 4).
    """
    count, objects = judged.shape
    levels = np.full((DRAWS, objects), -np.inf)
    own = np.flatnonzero(history.on_nothing())
    if len(own) == 0 or count < 2:
        return levels
    for draw, shift in enumerate(rng.integers(1, count, DRAWS)):
        at = (history.frame[own] - shift) % count
        which, target = np.nonzero(judged[at])
        row, then = own[which], at[which]
        on = np.linalg.norm(history.place_m[row] - place_m[then, target], axis=1) <= RADIUS_M
        row, then, target = row[on], then[on], target[on]
        on = overlaps_of(history.box_xyxy[row], box_xyxy[then, target])
        row, then, target = row[on], then[on], target[on]
        found = streaks(then, target * history.names + history.identity[row], history.confidence[row])
        levels[draw] = highest(found.key // history.names, found.level, objects)
    return levels
