"""Counts and distributions of the objects of a data set, from its tables alone: no pixel is read."""

from __future__ import annotations

from dataclasses import dataclass
from typing import get_args

import pandas as pd
import pyarrow as pa
import pyarrow.compute as pc

from benchmarks.data.sets.data_set import DataSet
from scenarios import catalog
from scenarios.truth import INSIDE, VisibilityState
from sim.checks import check

STATES: tuple[str, ...] = get_args(VisibilityState)
TARGET, OTHERS, STANDING = "target", "other objects", "standing about"
"""Groups of objects: the one that a tracker of a single target is started on, all others that the scene asks about, and
what is parked or moored.
"""
_OBJECT = ["seed", "index"]


@dataclass(frozen=True)
class Statistics:
    """What the objects of a data set do and show.

    Attributes:
        seen: number of objects of frames with at least one visible pixel; a row a kind, a column a group.
        states: share of each state among the objects of all frames; a row a group, a column a state.
        frame_outs: a row for each run of the state ``out`` of an object that was in the picture just before, with its
            ``group``, ``frames``, and ``unfinished``: it lasts to the episode's end, or to where the object leaves the
            world.
        sizes: a row for each object of a frame: ``group``, ``side_px``, the root of the area of its visible box (NaN:
            not seen), and ``visible_fraction`` (NaN: outside the picture or absent).
    """

    seen: pd.DataFrame
    states: pd.DataFrame
    frame_outs: pd.DataFrame
    sizes: pd.DataFrame


def statistics(data: DataSet) -> Statistics:
    """Return the statistics of a data set. Raises ValueError if there is no episode."""
    check("directory", len(data.seeds) > 0, "a data set with at least one whole episode", f"none in {data.url}")
    objects = _objects(data)
    kinds = [objects[objects["side_px"].notna()][["kind", "group"]]]
    if "standing" in data.tables:
        standing = _rows(data, "standing", {"kind": pc.field("standing_kinds"), "side_px": _side_px()})
        kinds.append(standing[standing["side_px"].notna()][["kind"]].assign(group=STANDING))
    seen = pd.concat([each.astype(str) for each in kinds])
    states = pd.crosstab(objects["group"], objects["state"], normalize="index").reindex(columns=STATES, fill_value=0.0)
    return Statistics(
        pd.crosstab(seen["kind"], seen["group"]).reindex(columns=[TARGET, OTHERS, STANDING], fill_value=0),
        states.reindex([TARGET, OTHERS]).dropna(),
        _frame_outs(objects),
        pd.DataFrame(
            {
                "group": objects["group"],
                "side_px": objects["side_px"],
                "visible_fraction": objects["visible_fraction"].where(objects["state"].isin(INSIDE)),
            }
        ),
    )


def _objects(data: DataSet) -> pd.DataFrame:
    """Return a row for each object of each frame, in order of seed and frame."""
    # A data set may have many millions of objects: in 18 bytes each.
    fields = {
        "seed": pc.field("seed").cast(pa.int32()),
        "index": pc.field("index"),
        "state": pc.field("state"),
        "visible_fraction": pc.field("visible_fraction").cast(pa.float32()),
    }
    is_target = pc.field("names") == catalog.scenario(data.request.scenario).target
    group = pc.if_else(is_target, TARGET, OTHERS)
    return _rows(data, "objects", fields | {"kind": pc.field("kinds"), "group": group, "side_px": _side_px()})


def _rows(data: DataSet, table: str, columns: dict[str, pc.Expression]) -> pd.DataFrame:
    return pa.Table.from_batches(data.batches(table, columns)).to_pandas(strings_to_categorical=True)


def _side_px() -> pc.Expression:
    x0, y0, x1, y1 = (pc.list_element(pc.field("visible_box_xyxy"), k) for k in range(4))
    return pc.sqrt((x1 - x0) * (y1 - y0)).cast(pa.float32())


def _frame_outs(objects: pd.DataFrame) -> pd.DataFrame:
    rows = objects[[*_OBJECT, "state", "group"]].sort_values(_OBJECT, kind="stable")
    begins = (rows[[*_OBJECT, "state"]] != rows[[*_OBJECT, "state"]].shift()).any(axis=1)
    runs = rows[begins].assign(frames=rows.groupby(begins.cumsum()).size().to_numpy())
    before, after = runs.shift(), runs.shift(-1)
    was_seen = (runs[_OBJECT] == before[_OBJECT]).all(axis=1) & before["state"].isin(INSIDE)
    ends = (runs[_OBJECT] != after[_OBJECT]).any(axis=1) | (after["state"] == "absent")
    return runs.assign(unfinished=ends)[(runs["state"] == "out") & was_seen][["group", "frames", "unfinished"]]
