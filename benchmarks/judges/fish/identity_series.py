"""Which identity each fish bears over time, as rows for the report's timelines."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from benchmarks.contract.judging import Score
from benchmarks.judges.fish.links import Bearers
from benchmarks.judges.runs import runs

MOST_FISH = 20
"""Fish of an episode whose identities are kept in rows and drawn."""
BORNE, GAPS = "identity_runs_", "gap_runs_"


def identity_series(borne: Bearers, apart: NDArray[np.bool_]) -> Iterator[Score]:
    """Yield ``identity_runs_FISH`` (*series*: first frame, end and identity of every run of frames with one identity)
    and ``gap_runs_FISH`` (*series*: first frame and end of every stretch not apart) of the first 20 fish.
    """
    for fish in range(min(apart.shape[1], MOST_FISH)):
        own = borne.identity[:, fish]
        spans = [(first, end, name) for name in np.unique(own[own >= 0]).tolist() for first, end in runs(own == name)]
        yield Score(f"{BORNE}{fish}", [float(number) for span in sorted(spans) for number in span])
        yield Score(f"{GAPS}{fish}", [float(number) for span in runs(~apart[:, fish]) for number in span])
