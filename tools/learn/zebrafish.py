"""How five real zebrafish swim, in the rows of ``motion``, to stand beside those of simulated fish.

Made from idTracker's tracks of the Tracktor project's video (Sridhar, Roche and Gingins 2019, MIT licence)::

    python -m tools.learn.zebrafish zebrafish_video_idtracked.txt

Places are scaled so that the box of all is as wide as the simulated tank. The file tells neither the size of the tank
nor that of the fish, which are taken to be as long, for their tank, as the simulated ones. The statistics are means
over pieces as long as an episode, since several of them depend on the length.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path

import pandas as pd

from benchmarks.data.tracks import read_tracks
from benchmarks.judges.fish.motion import motion_scores
from benchmarks.judges.fish.real import scaled_to_tank
from benchmarks.show.suites.fish import ZEBRAFISH
from scenarios.fish_tank.presets import PRESETS
from sim.checks import check

_BODY_PX = 35.0
"""Length of a simulated body in the overview's picture."""
PIECE_FRAMES = PRESETS["standard"].frame_count


def measured_rows(file: Path) -> dict[str, float]:
    """Return the statistics of a file of tracks by the name of their row: means over pieces of ``PIECE_FRAMES``.

    Raises:
        ValueError: for an unreadable or shorter file.
    """
    (table,) = read_tracks([file])
    check(table.name, len(table.position) >= PIECE_FRAMES, f"at least {PIECE_FRAMES} frames", len(table.position))
    position_px = scaled_to_tank(table.position)
    firsts = range(0, len(position_px) - PIECE_FRAMES + 1, PIECE_FRAMES)
    pieces = (motion_scores(position_px[first : first + PIECE_FRAMES], _BODY_PX) for first in firsts)
    means = pd.DataFrame([{score.metric: score.value for score in piece} for piece in pieces]).mean()
    return {str(name): float(f"{value:.4g}") for name, value in means.items()}


if __name__ == "__main__":
    ZEBRAFISH.write_text(json.dumps(measured_rows(Path(sys.argv[1])), indent=1) + "\n")
