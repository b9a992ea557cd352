"""How five real zebrafish swim, in the rows of ``motion``, to stand beside those of simulated fish.

Made from idTracker's tracks of the Tracktor project's video (Sridhar, Roche and Gingins 2019, MIT licence)::

    python -m benchmarks.suites.fish.zebrafish zebrafish_video_idtracked.txt

Places are scaled so that the box of all is as wide as the simulated tank. The file tells neither the size of the tank
nor that of the fish, which are taken to be as long, for their tank, as the simulated ones.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path

import numpy as np

from benchmarks.suites.fish.motion import motion_scores
from benchmarks.track_files.reading import read_tracks

_FILE = Path(__file__).with_suffix(".json")
_TANK_PX, _BODY_PX = 600.0, 35.0
"""Length of the simulated tank, and of a body, in the overview's picture."""


def zebrafish_rows() -> dict[str, float]:
    """Return the stored statistics by the name of their row."""
    return dict(json.loads(_FILE.read_text()))


def measured_rows(file: Path) -> dict[str, float]:
    """Return the statistics of a file of tracks by the name of their row. Raises ValueError for an unreadable file."""
    (table,) = read_tracks([file])
    width = np.nanmax(table.position[..., 0]) - np.nanmin(table.position[..., 0])
    scores = motion_scores(table.position * (_TANK_PX / width), _BODY_PX)
    return {score.metric: float(f"{score.value:.4g}") for score in scores}


if __name__ == "__main__":
    _FILE.write_text(json.dumps(measured_rows(Path(sys.argv[1])), indent=1) + "\n")
