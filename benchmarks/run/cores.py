"""Worker processes: how many, and what joblib tells about them in vain."""

from __future__ import annotations

import warnings

import joblib
import numpy as np

from sim.checks import check

# joblib replaces a worker that has grown by 300 MB, for which a kept town is enough, and tells it like a fault.
warnings.filterwarnings("ignore", "A worker stopped while some jobs were given", UserWarning)


def cores(workers: int | None) -> int:
    """Return the number of workers, by default one for each core of this process.

    Raises:
        ValueError: unless it is a whole number >= 0.
    """
    whole = isinstance(workers, int | np.integer) and not isinstance(workers, bool)
    check("workers", workers is None or (whole and workers >= 0), "a whole number >= 0", repr(workers))
    return joblib.cpu_count() if workers is None else workers
