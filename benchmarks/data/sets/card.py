"""The data card: what a data set is, what it holds, how it was made; and what it shares with the READMEs of exports."""

from __future__ import annotations

from dataclasses import dataclass
from fnmatch import fnmatch
from pathlib import Path
from typing import Any

import cv2

from benchmarks.contract.rows import TEST_SPLIT
from benchmarks.contract.text import counted, ranges_text
from benchmarks.data.sets.channels import NORMALS, coding_of
from benchmarks.data.sets.contact_sheet import LEGEND, contact_sheet
from benchmarks.data.sets.data_set import MANIFEST, DataSet
from benchmarks.data.sets.places import put
from benchmarks.data.sets.statistics import STATES, Statistics, statistics
from benchmarks.show.page import page_environment
from benchmarks.show.tables import markdown_table
from scenarios import catalog
from scenarios.truth import meanings

CARD, SHEET = "README.md", "contact-sheet.jpg"
_UNITS = {NORMALS: "unit vectors in the world"}
AXES = Path(__file__).with_name("axes.md").read_text(encoding="utf-8")
"""Text of all READMEs: where axes and pixels begin."""
_SIZES = ("n<1K", "1K<n<10K", "10K<n<100K", "100K<n<1M", "1M<n<10M", "10M<n<100M", "100M<n<1B")
"""Words of the Hugging Face Hub for powers of ten of samples."""
_TASKS = {
    "instance_map": ("object-detection", "image-segmentation"),
    "depth_m": ("depth-estimation",),
}
"""Channel -> tasks of the Hub that it is truth for."""


def split_of(seed: int) -> str:
    """Return ``test`` for a seed of the test split, else ``train``."""
    return "test" if seed in TEST_SPLIT else "train"


def hub_head(data: DataSet, configs: dict[str, dict[str, list[str]]]) -> str:
    """Return the head in YAML by which the Hugging Face Hub lists a data set and ``load_dataset`` finds its splits.

    Args:
        configs: name of a configuration -> split -> patterns of files; the first one is the default.
    """
    power = len(str(max(len(data) - 1, 0))) - 3
    return _render(
        "hub_head.yaml.jinja",
        request=data.request,
        tasks=[task for channel, of in _TASKS.items() if channel in data.request.channels for task in of],
        size=_SIZES[min(max(power, 0), len(_SIZES) - 1)],
        configs=configs,
    )


def table_configs(data: DataSet) -> dict[str, dict[str, list[str]]]:
    """Return the configurations of a data set's tables: frames, objects and what stands about."""
    test = f"{TEST_SPLIT.start // 10_000:02d}*"
    folders = {"train": ["00*", "0[2-9]*", "[1-9]*"], "test": [test]}
    found = {
        split: [each for each in patterns if any(fnmatch(f"{seed:06d}", each) for seed in data.seeds)]
        for split, patterns in folders.items()
    }
    return {
        table: {
            split: [f"episodes/{folder}/{table}.parquet" for folder in patterns]
            for split, patterns in found.items()
            if patterns
        }
        for table in data.tables
    }


@dataclass(frozen=True)
class CardTable:
    """A table of the card and the page: heads, lines of cells, and how many columns are words (the rest: numbers)."""

    heads: tuple[str, ...]
    lines: list[list[str]]
    words: int = 1


def about(data: DataSet) -> list[str]:
    """Return what a data set is, what it lacks and what made it, a sentence each."""
    request, first = data.request, data.episode(data.seeds[0])
    missing = [f"Missing: seeds {ranges_text(data.missing())}."] if data.missing() else []
    packages = ", ".join(f"{name} {version}" for name, version in request.packages.items())
    return [
        f"{counted(len(data.seeds), 'episode')} (seeds {ranges_text(data.seeds)}), {len(data)} frames of "
        f"{first.camera.width_px} x {first.camera.height_px} pixels at {first.rate_hz:g} a second; "
        f"drawn by the renderer `{request.renderer}`.",
        *missing,
        *(f"Left out, since it could not be built: seed {seed}: {why}" for seed, why in data.left_out.items()),
        "Simulated by Frameout; nobody is recorded. Licence: MIT, that of Frameout. The same request gives the "
        "same bytes with the same edition (`scene` in `dataset.json`), on Linux with AVX2.",
        f"Made with {packages or 'packages that were not noted'}.",
    ]


def card_tables(data: DataSet, held: Statistics) -> list[CardTable]:
    """Return what the objects do, what pictures show, and what each channel takes."""
    lines = []
    for group, shares in held.states.iterrows():
        outs = held.frame_outs[held.frame_outs["group"] == group]
        frames = outs["frames"]
        lengths = f"{frames.median():g}, {frames.max()}" if len(outs) else ""
        percent = [f"{100 * share:.1f}" for share in shares]
        lines.append([str(group), *percent, str(len(outs)), str(outs["unfinished"].sum()), lengths])
    heads = (*(f"{state} (%)" for state in STATES), "frame-outs", "to the end", "frames of one: median, longest")
    objects = CardTable(("objects", *heads), lines)
    seen = CardTable(
        ("seen in pictures", *held.seen.columns), [[kind, *map(str, row)] for kind, *row in held.seen.itertuples()]
    )
    stored, pictures = data.stored_bytes(), data.request.pictures
    units = {name: each.unit for name, each in meanings(catalog.scenario(data.request.scenario).truth).items()} | _UNITS
    channels = [
        [
            name,
            coding_of(name, pictures) if name != "tables" else "Parquet",
            units.get(name, ""),
            f"{size / len(data) / 1024:.1f}",
        ]
        for name, size in stored.items()
    ]
    return [objects, seen, CardTable(("channel", "coding", "unit", "KiB a frame"), channels, words=3)]


def write_card(data: DataSet) -> None:
    """Write the data card into a data set."""
    sheet = cv2.imencode(".jpg", cv2.cvtColor(contact_sheet(data), cv2.COLOR_RGB2BGR))[1].tobytes()
    put(data.files, f"{data.root}/{SHEET}", sheet)
    put(data.files, f"{data.root}/{CARD}", _text(data).encode())


def _text(data: DataSet) -> str:
    scenario = catalog.scenario(data.request.scenario)
    fields = [
        [f"`{name}`", each.table, each.unit, each.coding]
        for name, each in meanings(scenario.truth).items()
        if not each.per_pixel
    ]
    tables = card_tables(data, statistics(data))
    return _render(
        "card.md.jinja",
        head=hub_head(data, table_configs(data)),
        request=data.request,
        summary=scenario.summary,
        about=about(data),
        sheet=SHEET,
        legend=LEGEND,
        tables=[markdown_table(each.heads, each.lines, each.words) for each in tables],
        manifest=MANIFEST,
        fields=markdown_table(("field", "table", "unit", "coding"), fields, 4),
        axes=AXES,
    )


def _render(template: str, **values: Any) -> str:
    return page_environment(__file__, autoescape=False).get_template(template).render(values)
