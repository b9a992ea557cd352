"""How the suite ``fish`` is shown."""

from __future__ import annotations

import json
from pathlib import Path

from benchmarks.judges.fish.motion import ANY, LAGS, MOTION
from benchmarks.show.facts import Facts
from benchmarks.show.fish.drawing import FishDrawing
from benchmarks.show.fish.figures import figures
from benchmarks.show.showing import Showing

ZEBRAFISH = Path(__file__).with_name("zebrafish.json")
"""How five real zebrafish swim, in the rows of ``judges.fish.motion``; made by ``tools.learn.zebrafish``."""
SWIMS = Facts(
    title="How they swim",
    words="Of true places in episodes, of the file's in real tracks; means over episodes or blocks of time, with 95 % "
    "bootstrap intervals. Directions are those of the velocity over 5 frames. Real zebrafish: five in a video (Sridhar "
    "et al. 2019), tracked by idTracker, scaled so that their tank is as long in the picture as the simulated one; "
    "means over pieces as long as an episode.",
    lines={**{f"over {lag} frames": lag for lag in LAGS}, "at any time": ANY},
    columns=MOTION,
    beside={"real zebrafish": json.loads(ZEBRAFISH.read_text())},
)
SHOWING = Showing(
    heading="Does every fish keep its name?",
    figures=figures,
    facts=SWIMS,
    drawings={"fish-tank": FishDrawing},
)
