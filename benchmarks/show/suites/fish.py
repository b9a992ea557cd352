"""How the suite ``fish`` is shown."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path

from benchmarks.contract.metric import Mean, Quantity
from benchmarks.contract.rows import Row
from benchmarks.judges.fish.gap_protocol import GAP_FRAMES
from benchmarks.judges.fish.motion import ANY, LAGS, MOTION
from benchmarks.show.charts import Chart, curves_of, lines_of, series_mean
from benchmarks.show.showing import Showing
from benchmarks.show.tables import Facts
from benchmarks.show.video.fish import FishDrawing

_LINK_GROUPS = {
    "up to 50 frames": "50",
    "fish cross": "crossing_50",
    "fish touch": "touching_50",
    "two fish": "pair_50",
    "three or more": "crowd_50",
    "up to 200 frames": "200",
}
"""Words of the chart → group of gaps."""
ZEBRAFISH = Path(__file__).with_name("zebrafish.json")
"""How five real zebrafish swim, in the rows of ``judges.fish.motion``; made by ``tools.learn.zebrafish``."""
SWIMS = Facts(
    title="How they swim",
    words="Of true places in episodes, of the file's in real tracks; means over episodes or blocks of time, with 95 % "
    "bootstrap intervals. Directions are those of the velocity over 5 frames. Real zebrafish: five in a video (Sridhar "
    "et al. 2019), tracked by idTracker, scaled so that their tank is as long in the picture as the simulated one; "
    "means over pieces as long as an episode.",
    lines={**{f"over {lag} frames": str(lag) for lag in LAGS}, "at any time": ANY},
    columns=MOTION,
    beside={"real zebrafish": json.loads(ZEBRAFISH.read_text())},
)


def charts(drawn: Mapping[str, Sequence[Row]]) -> list[Chart]:
    """Return the error over the length of a gap, and links by kind of gap."""
    links = {name: Mean(Quantity(f"link_precision_{group}")) for name, group in _LINK_GROUPS.items()}
    return [
        Chart(
            title="How far off is a lost fish?",
            words=f"Mean distance to the true place on each frame of gaps of {GAP_FRAMES[-1]} frames, the far end "
            "unknown.",
            curves=curves_of(drawn, lambda rows: series_mean(rows, "gap_error_by_frame_px", first_x=1.0)),
            x_label="frames since the track was lost",
            x_scale="frames",
            y_label="error, px",
            y_scale="log",
        ),
        Chart(
            title="Which links are right?",
            words="Right links of those made, over the gaps on which a fish touches, crosses or hides behind another.",
            lines=lines_of(links, drawn),
            x_label="right links",
            x_scale="share",
        ),
    ]


SHOWING = Showing(
    heading="Does every fish keep its name?",
    charts=charts,
    facts=SWIMS,
    drawings={"fish-tank": FishDrawing},
)
