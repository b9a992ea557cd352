"""Columns of a data set's tables as arrays of numbers. No pixel is read, and no column that is not asked for."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, Literal, get_args

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
from numpy.typing import NDArray

from benchmarks.data.sets.data_set import DataSet
from benchmarks.data.sets.tables import frame_schema, object_schema
from scenarios import catalog
from scenarios.truth import VisibilityState, meanings

STATES: tuple[str, ...] = get_args(VisibilityState)
TARGET, OTHERS, STANDING = "target", "other objects", "standing about"
"""Groups of objects: the one that a tracker of a single target is started on, all others that the scene asks about, and
what is parked or moored.
"""
_SEEN = tuple(STATES.index(state) for state in ("in", "partial", "occluded"))
_OUT, _ABSENT = STATES.index("out"), STATES.index("absent")
_TOLD_ELSEWHERE = ("frame", "time_s", "visible_fraction", "state", "side", "frames_since_exit")

ByGroup = dict[str, NDArray[np.float64]]
Kind = Literal["number", "flag", "word"]


@dataclass(frozen=True, slots=True)
class Quantity:
    """A number, flag or word that each frame or each object of a frame has.

    Attributes:
        table: ``frames`` or ``objects``. path: the column, and the fields inside it if it is a structure.
        unit: as in ``Meaning``. kind: of its values.
    """

    table: str
    path: tuple[str, ...]
    unit: str
    kind: Kind

    @property
    def name(self) -> str:
        """Its column and fields, ``light.sky_illuminance_lx``."""
        return ".".join(self.path)


@dataclass(frozen=True, slots=True)
class FrameOuts:
    """The frame-outs of a group of objects.

    Attributes:
        lengths: (K,) frames of each.
        unfinished: how many of them last to the episode's end, or to where the object leaves the world.
    """

    lengths: NDArray[np.int64]
    unfinished: int


def quantities(data: DataSet) -> tuple[Quantity, ...]:
    """Return all numbers, flags and words of the scene's truth: of frames, and of objects without indices and words."""
    kind = catalog.scenario(data.request.scenario).truth
    schemas = {"frames": frame_schema(kind, ()), "objects": object_schema(kind)}
    found: list[Quantity] = []
    for name, meaning in meanings(kind).items():
        if meaning.table in schemas and name not in _TOLD_ELSEWHERE:
            table = meaning.table
            found += _leaves(table, (name,), schemas[table].field(name).type, meaning.unit)
    return tuple(each for each in found if each.kind != "word" or each.table == "frames")


def _leaves(table: str, path: tuple[str, ...], kind: pa.DataType, unit: str) -> list[Quantity]:
    if pa.types.is_struct(kind):
        return [leaf for field in kind for leaf in _leaves(table, (*path, field.name), field.type, unit)]
    if pa.types.is_boolean(kind):
        return [Quantity(table, path, unit, "flag")]
    if pa.types.is_floating(kind) or (pa.types.is_integer(kind) and table == "frames"):
        return [Quantity(table, path, unit, "number")]
    return [Quantity(table, path, unit, "word")] if pa.types.is_string(kind) else []


def numbers(data: DataSet, quantity: Quantity) -> ByGroup:
    """Return the finite values of a number or flag: of objects in the world by group, of frames under ``""``.

    Groups without values are left out.
    """
    wanted = {"value": pc.field(*quantity.path)}
    if quantity.table == "frames":
        batches = data.batches("frames", wanted)
        found = _finite(np.concatenate([_floats(batch["value"]) for batch in batches]))
        return {"": found} if len(found) else {}
    parts = []
    for batch, mine in _objects(data, wanted | {"state": pc.field("state")}):
        present = _states(batch) != _ABSENT
        parts.append((_floats(batch["value"])[present], mine[present]))
    return _by_group(parts)


def words(data: DataSet, quantity: Quantity) -> dict[str, int]:
    """Return how many frames have each word; ``none`` for those without one."""
    counts: dict[str, int] = {}
    for batch in data.batches(quantity.table, {"value": pc.field(*quantity.path)}):
        for entry in pc.value_counts(batch["value"]).to_pylist():
            word = "none" if entry["values"] is None else entry["values"]
            counts[word] = counts.get(word, 0) + entry["counts"]
    return dict(sorted(counts.items(), key=lambda item: -item[1]))


def visible_fractions(data: DataSet) -> ByGroup:
    """Return the visible fractions of the objects that are at least in part within the picture's borders."""
    wanted = {"value": pc.field("visible_fraction"), "state": pc.field("state")}
    parts = []
    for batch, mine in _objects(data, wanted):
        inside = np.isin(_states(batch), _SEEN)
        parts.append((_floats(batch["value"])[inside], mine[inside]))
    return _by_group(parts)


def box_sides_px(data: DataSet) -> ByGroup:
    """Return the roots of the areas of the visible boxes, pixels."""
    parts = []
    for batch, mine in _objects(data, {"box": pc.field("visible_box_xyxy")}):
        x0, y0, x1, y1 = _floats(batch["box"].flatten()).reshape(-1, 4).T
        parts.append((np.sqrt((x1 - x0) * (y1 - y0)), mine))
    return _by_group(parts)


def seen_counts(data: DataSet) -> dict[str, dict[str, int]]:
    """Return how many objects of frames show at least one pixel, by kind and group, in the order of the kinds."""
    counts: dict[tuple[str, str], int] = {}

    def add(kinds: pa.Array, boxes: pa.Array, group: str, mine: NDArray[np.bool_] | bool = True) -> None:
        shown = np.isfinite(_floats(boxes.flatten()).reshape(-1, 4)[:, 0]) & mine
        for entry in pc.value_counts(kinds.filter(pa.array(shown))).to_pylist():
            key = entry["values"], group
            counts[key] = counts.get(key, 0) + entry["counts"]

    for batch, mine in _objects(data, {"kind": pc.field("kinds"), "box": pc.field("visible_box_xyxy")}):
        add(batch["kind"], batch["box"], TARGET, mine)
        add(batch["kind"], batch["box"], OTHERS, ~mine)
    if "standing" in data.tables:
        wanted = {"kind": pc.field("standing_kinds"), "box": pc.field("visible_box_xyxy")}
        for batch in data.batches("standing", wanted):
            add(batch["kind"], batch["box"], STANDING)
    found: dict[str, dict[str, int]] = {}
    for kind, group in sorted(counts):
        found.setdefault(kind, {})[group] = counts[kind, group]
    return found


def state_counts(data: DataSet) -> dict[str, dict[str, int]]:
    """Return how many objects of frames are in each state, by group."""
    counts = np.zeros((2, len(STATES)), dtype=np.int64)
    for batch, mine in _objects(data, {"state": pc.field("state")}):
        states = _states(batch)
        for k, chosen in enumerate((mine, ~mine)):
            counts[k] += np.bincount(states[chosen], minlength=len(STATES))
    named = zip((TARGET, OTHERS), counts, strict=True)
    return {group: dict(zip(STATES, each.tolist(), strict=True)) for group, each in named if each.any()}


def frame_outs(data: DataSet) -> dict[str, FrameOuts]:
    """Return the runs of state ``out`` of objects that were in the picture just before, by group."""
    wanted = {"seed": pc.field("seed"), "index": pc.field("index"), "state": pc.field("state")}
    parts = [
        (_floats(batch["seed"]).astype(np.int64), np.asarray(batch["index"]), _states(batch), mine)
        for batch, mine in _objects(data, wanted)
    ]
    seed, index, state, mine = (np.concatenate(column) for column in zip(*parts, strict=True))
    # Rows are in order of seed and frame: a stable order by object keeps that of the frames.
    order = np.lexsort((index, seed))
    seed, index, state, mine = seed[order], index[order], state[order], mine[order]
    same = (np.diff(seed) == 0) & (np.diff(index) == 0)
    goes_on = same & (np.diff(state) == 0)
    first = np.flatnonzero((state == _OUT) & np.concatenate([[True], ~goes_on]))
    last = np.flatnonzero((state == _OUT) & np.concatenate([~goes_on, [True]]))
    left = np.concatenate([[False], same & np.isin(state[:-1], _SEEN)])[first]
    first, last = first[left], last[left]
    ends = np.concatenate([~same | (state[1:] == _ABSENT), [True]])[last]
    found = {}
    for group, chosen in ((TARGET, mine[first]), (OTHERS, ~mine[first])):
        if chosen.any():
            found[group] = FrameOuts(last[chosen] - first[chosen] + 1, int(ends[chosen].sum()))
    return found


def _objects(data: DataSet, columns: dict[str, Any]) -> Iterator[tuple[pa.RecordBatch, NDArray[np.bool_]]]:
    """Yield rows of ``objects``, and which of them are of the target."""
    target = catalog.scenario(data.request.scenario).target
    for batch in data.batches("objects", columns | {"is_target": pc.field("names") == target}):
        yield batch, batch["is_target"].to_numpy(zero_copy_only=False).astype(bool)


def _states(batch: pa.RecordBatch) -> NDArray[np.int8]:
    return pc.index_in(batch["state"], value_set=pa.array(STATES)).to_numpy(zero_copy_only=False).astype(np.int8)


def _floats(column: pa.Array) -> NDArray[np.float64]:
    return column.cast(pa.float64()).to_numpy(zero_copy_only=False)


def _finite(values: NDArray[np.float64]) -> NDArray[np.float64]:
    return values[np.isfinite(values)]


def _by_group(parts: list[tuple[NDArray[np.float64], NDArray[np.bool_]]]) -> ByGroup:
    values, mine = (np.concatenate(column) for column in zip(*parts, strict=True))
    groups = {TARGET: _finite(values[mine]), OTHERS: _finite(values[~mine])}
    return {group: each for group, each in groups.items() if len(each)}
