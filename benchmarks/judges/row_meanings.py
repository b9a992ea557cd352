"""Ranges, conditions and sources of rows that several suites have."""

from __future__ import annotations

from math import inf

from benchmarks.contract.metric import OWN, RowMeaning
from benchmarks.judges.tracker_speed import TIMES

SPEED = RowMeaning(TIMES, 0, inf, "every frame but the tracker's first five", OWN)
_HOTA = "HOTA: Luiten et al., HOTA: a higher order metric for evaluating multi-object tracking, IJCV 129, 2021"
_IDF1 = "IDF1: Ristani et al., Performance measures and a data set for multi-target, multi-camera tracking, ECCV 2016"
KAPLAN_MEIER = "Kaplan and Meier, Nonparametric estimation from incomplete observations, JASA 53, 1958"
_OXUVA = "OxUvA: Valmadre et al., Long-term tracking in the wild: a benchmark, ECCV 2018"
IN_VIEW = (
    RowMeaning(("in_view_tpr",), 0, 1, "frames with the whole target in the picture, at least half of it seen", _OXUVA),
    RowMeaning(("in_view_tnr",), 0, 1, "frames with the target outside, or less than a tenth of it seen", _OXUVA),
)


def time_in_view(episodes: str) -> tuple[RowMeaning, ...]:
    """Return what holds of ``scores.view_time``'s rows in these ``episodes``, in words."""
    when = f"{episodes}: every frame but the first"
    return (
        RowMeaning(("time_seen", "time_in_view"), 0, 1, when, OWN),
        RowMeaning(("losses_per_minute",), 0, inf, when, OWN),
    )


def identities(frames: str, ending: str = "") -> tuple[RowMeaning, ...]:
    """Return what holds of the scores of whole tracks; ``frames`` count, in words; ``ending``: of the rows' names."""
    counts = tuple(f"identity_{kind}_frames{ending}" for kind in ("right", "false", "missed"))
    clear = "CLEAR: Bernardin and Stiefelhagen, Evaluating multiple object tracking performance, EURASIP JIVP 2008"
    return (
        RowMeaning((f"hota{ending}",), 0, 1, frames, _HOTA),
        RowMeaning(counts, 0, inf, frames, _IDF1),
        RowMeaning((f"mota{ending}",), -inf, 1, frames, clear),
        RowMeaning((f"identity_switches{ending}",), 0, inf, frames, clear),
    )
