"""The data card: what a data set is, what it holds, how it was made; and what it shares with the READMEs of exports."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from fnmatch import fnmatch
from typing import Any, get_args

import pandas as pd
import pyarrow as pa
import pyarrow.compute as pc

from benchmarks.contract.rows import TEST_SPLIT
from benchmarks.contract.text import counted, ranges_text
from benchmarks.data.sets.channels import CODINGS, NORMALS, coding_of
from benchmarks.data.sets.contact_sheet import LEGEND, contact_sheet
from benchmarks.data.sets.data_set import DataSet
from benchmarks.data.sets.manifest import MANIFEST
from benchmarks.data.sets.places import put
from benchmarks.show.page import page_environment
from benchmarks.show.tables import markdown_table
from scenarios import catalog
from scenarios.truth import INSIDE, VisibilityState, meanings

CARD, SHEET = "README.md", "contact-sheet.jpg"
TARGET, OTHERS, STANDING = "target", "other objects", "standing about"
"""Groups of objects: the one that a tracker of a single target is started on, all others that the scene asks about, and
what is parked or moored.
"""
_STATES: tuple[str, ...] = get_args(VisibilityState)
_SIZES = ("n<1K", "1K<n<10K", "10K<n<100K", "100K<n<1M", "1M<n<10M", "10M<n<100M", "100M<n<1B")
"""Words of the Hugging Face Hub for powers of ten of samples."""
_MOST_LISTED = 1000
"""Episodes that the head of a card names one by one."""
_MOST_LOOKED_AT = 500
_TASKS = {
    "instance_map": ("object-detection", "image-segmentation"),
    "depth_m": ("depth-estimation",),
}
"""Channel -> tasks of the Hub that it is truth for."""


def tasks_of(channels: Collection[str]) -> list[str]:
    """Return the tasks of the Hub that channels are truth for."""
    return [task for channel, tasks in _TASKS.items() if channel in channels for task in tasks]


def axes_text(channels: Collection[str]) -> str:
    """Return the part of a README that says where axes and pixels begin, those of channels too."""
    return _render("axes.md.jinja", channels=channels) + "\n"


def hub_head(data: DataSet, configs: dict[str, dict[str, list[str]]], tasks: Sequence[str]) -> str:
    """Return the head in YAML by which the Hugging Face Hub lists a data set and ``load_dataset`` finds its splits.

    Args:
        configs: name of a configuration -> split -> patterns of files; the first one is the default.
        tasks: of the Hub.
    """
    power = len(str(max(len(data) - 1, 0))) - 3
    return _render(
        "hub_head.yaml.jinja",
        request=data.request,
        tasks=tasks,
        size=_SIZES[min(max(power, 0), len(_SIZES) - 1)],
        configs=configs,
    )


def table_configs(data: DataSet) -> dict[str, dict[str, list[str]]]:
    """Return the configurations of a data set's tables: frames, objects and what stands about. Splits by share have a
    pattern an episode; where these would be too many there are none.
    """
    if data.request.splits:
        folders = {split: [f"{seed:06d}" for seed in seeds] for split, seeds in data.splits.items()}
        if len(data.seeds) > _MOST_LISTED:
            return {}
    else:
        wide = {"train": ["00*", "0[2-9]*", "[1-9]*"], "test": [f"{TEST_SPLIT.start // 10_000:02d}*"]}
        folders = {
            split: [each for each in wide[split] if any(fnmatch(f"{seed:06d}", each) for seed in seeds)]
            for split, seeds in data.splits.items()
        }
    return {
        table: {split: [f"episodes/{folder}/{table}.parquet" for folder in found] for split, found in folders.items()}
        for table in data.tables
    }


def write_card(data: DataSet) -> None:
    """Write the data card and the contact sheet into a data set."""
    if data.request.channels:
        put(data.files, f"{data.root}/{SHEET}", CODINGS["jpeg"].encode(contact_sheet(data)))
    put(data.files, f"{data.root}/{CARD}", card_text(data).encode())


def card_text(data: DataSet) -> str:
    """Return the data card; no pixel is read."""
    request, scenario = data.request, catalog.scenario(data.request.scenario)
    looked_at = looked_at_in(data.seeds)
    fields = meanings(scenario.truth)
    return _render(
        "card.md.jinja",
        head=hub_head(data, table_configs(data), tasks_of(request.channels)),
        request=request,
        summary=scenario.summary,
        episodes=counted(len(data.seeds), "episode"),
        seeds=ranges_text(data.seeds),
        missing=ranges_text(data.missing()),
        splits=", ".join(f"{name} {counted(len(seeds), 'episode')}" for name, seeds in data.splits.items()),
        data=data,
        first=data.episode(data.seeds[0]),
        packages=", ".join(f"{name} {version}" for name, version in request.packages.items()),
        sheet=SHEET,
        legend=LEGEND,
        tables=[*_object_tables(data, looked_at), _channel_table(data, looked_at)],
        looked_at=counted(len(looked_at), "episode") if len(looked_at) < len(data.seeds) else "",
        manifest=MANIFEST,
        fields=markdown_table(
            ("field", "table", "unit", "coding"),
            [[f"`{name}`", each.table, each.unit, each.coding] for name, each in fields.items() if not each.per_pixel],
            4,
        ),
        axes=axes_text(request.channels),
    )


def looked_at_in(seeds: Sequence[int]) -> Sequence[int]:
    """Return those of the episodes that a card counts in, evenly spread: all, unless that would take minutes."""
    if len(seeds) <= _MOST_LOOKED_AT:
        return seeds
    return [seeds[len(seeds) * k // _MOST_LOOKED_AT] for k in range(_MOST_LOOKED_AT)]


def _object_tables(data: DataSet, looked_at: Sequence[int]) -> Iterator[str]:
    """Yield what the objects do, and how many of each kind are seen."""
    is_seen = pc.is_finite(pc.list_element(pc.field("visible_box_xyxy"), 0))
    is_target = pc.field("names") == catalog.scenario(data.request.scenario).target
    # A data set may have many millions of objects.
    columns = {
        "seed": pc.field("seed").cast(pa.int32()),
        "index": pc.field("index"),
        "state": pc.field("state"),
        "kind": pc.field("kinds"),
        "group": pc.if_else(is_target, TARGET, OTHERS),
        "is_seen": is_seen,
    }
    objects = _rows(data, "objects", columns, looked_at)
    outs = frame_outs(objects)
    shares = pd.crosstab(objects["group"], objects["state"], normalize="index").reindex(columns=_STATES, fill_value=0.0)
    lines = []
    for group in (each for each in (TARGET, OTHERS) if each in shares.index):
        own = outs[outs["group"] == group]
        lengths = f"{own['frames'].median():g}, {own['frames'].max()}" if len(own) else ""
        states = [f"{100 * share:.1f}" for share in shares.loc[group]]
        lines.append([group, *states, str(len(own)), str(own["unfinished"].sum()), lengths])
    heads = (*(f"{state} (%)" for state in _STATES), "frame-outs", "to the end", "frames of one: median, longest")
    yield markdown_table(("objects", *heads), lines, 1)

    seen = [objects.loc[objects["is_seen"], ["kind", "group"]]]
    if "standing" in data.tables:
        standing = _rows(data, "standing", {"kind": pc.field("standing_kinds"), "is_seen": is_seen}, looked_at)
        seen.append(standing.loc[standing["is_seen"], ["kind"]].assign(group=STANDING))
    found = pd.concat([each.astype(str) for each in seen])
    groups = [TARGET, OTHERS, STANDING]
    counts = pd.crosstab(found["kind"], found["group"]).reindex(columns=groups, fill_value=0)
    yield markdown_table(
        ("seen in pictures", *groups), [[kind, *map(str, row)] for kind, *row in counts.itertuples()], 1
    )


def _rows(data: DataSet, table: str, columns: dict[str, pc.Expression], seeds: Sequence[int]) -> pd.DataFrame:
    return pa.Table.from_batches(data.batches(table, columns, seeds)).to_pandas(strings_to_categorical=True)


def frame_outs(objects: pd.DataFrame) -> pd.DataFrame:
    """Return each run of the state ``out`` of an object that was in the picture just before.

    Args:
        objects: a row for each object of each frame, in order of frames: ``seed``, ``index``, ``state``, ``group``.

    Returns:
        ``group``, ``frames``, and ``unfinished``: it lasts to the episode's end, or to where the object leaves the
        world.
    """
    named = ["seed", "index"]
    rows = objects[[*named, "state", "group"]].sort_values(named, kind="stable")
    begins = (rows[[*named, "state"]] != rows[[*named, "state"]].shift()).any(axis=1)
    runs = rows[begins].assign(frames=rows.groupby(begins.cumsum()).size().to_numpy())
    before, after = runs.shift(), runs.shift(-1)
    was_seen = (runs[named] == before[named]).all(axis=1) & before["state"].isin(INSIDE)
    ends = (runs[named] != after[named]).any(axis=1) | (after["state"] == "absent")
    return runs.assign(unfinished=ends)[(runs["state"] == "out") & was_seen][["group", "frames", "unfinished"]]


def _channel_table(data: DataSet, looked_at: Sequence[int]) -> str:
    """Return what each channel takes."""
    units = {name: each.unit for name, each in meanings(catalog.scenario(data.request.scenario).truth).items()}
    units |= {NORMALS: "unit vectors in the world"}
    lines, frames = [], sum(data.episode(seed).frame_count for seed in looked_at)
    for name, size in data.stored_bytes(looked_at).items():
        coding = "Parquet" if name == "tables" else coding_of(name, data.request.pictures)
        lines.append([name, coding, units.get(name, ""), f"{size / frames / 1024:.1f}"])
    return markdown_table(("channel", "coding", "unit", "KiB a frame"), lines, 3)


def _render(template: str, **values: Any) -> str:
    return page_environment(__file__, autoescape=False).get_template(template).render(values)
