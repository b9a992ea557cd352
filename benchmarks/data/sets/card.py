"""The data card: what a data set is, what it holds, how it was made."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import cv2

from benchmarks.contract.text import counted, ranges_text
from benchmarks.data.sets.channels import NORMALS, coding_of
from benchmarks.data.sets.data_set import MANIFEST, DataSet
from benchmarks.data.sets.notes import COORDINATES, hub_head, table_configs
from benchmarks.data.sets.page.scans import OTHERS, STANDING, TARGET
from benchmarks.data.sets.page.sheets import contact_sheet
from benchmarks.data.sets.page.statistics import statistics
from benchmarks.data.sets.places import put
from scenarios import catalog
from scenarios.truth import Meaning, meanings

CARD, SHEET = "README.md", "contact-sheet.jpg"
_UNITS = {NORMALS: "unit vectors in the world"}


def write_card(data: DataSet) -> None:
    """Write the data card into a data set."""
    sheet = cv2.imencode(".jpg", cv2.cvtColor(contact_sheet(data), cv2.COLOR_RGB2BGR))[1].tobytes()
    put(data.files, f"{data.root}/{SHEET}", sheet)
    put(data.files, f"{data.root}/{CARD}", _text(data).encode())


def _text(data: DataSet) -> str:
    request, scenario = data.request, catalog.scenario(data.request.scenario)
    told = meanings(scenario.truth)
    made_with = ", ".join(f"{name} {version}" for name, version in request.packages.items())
    stored, frames = data.stored_bytes(), len(data)
    held = statistics(data)
    first = data.episode(data.seeds[0])
    camera = first.camera
    channels = [
        f"| `{channel}` | {coding_of(channel, request.pictures)} | {stored[channel] / frames / 1024:.1f} "
        f"| {_unit(told, channel)} |"
        for channel in request.channels
    ]
    fields = [f"| `{name}` | {m.table} | {m.unit} | {m.coding} |" for name, m in told.items() if not m.per_pixel]
    return hub_head(data, table_configs(data)) + "\n".join(
        [
            f"# {request.scenario}, {request.preset}: {scenario.summary}",
            "",
            f"{counted(len(data.seeds), 'episode')} (seeds {ranges_text(data.seeds)}), {frames} frames of "
            f"{camera.width_px} x {camera.height_px} pixels at {first.rate_hz:g} a second; "
            f"drawn by the renderer `{request.renderer}`.",
            "",
            *(f"Left out, since it could not be built: seed {seed}: {why}\n" for seed, why in data.left_out.items()),
            "Simulated by Frameout; nobody is recorded. Licence: MIT, that of Frameout. The same request gives the "
            "same bytes with the same edition (`scene` in `dataset.json`), on Linux with AVX2.",
            "",
            f"Made with {made_with or 'packages that were not noted'}.",
            "",
            f"![Frames with visible and amodal boxes.]({SHEET})",
            "",
            *_held(held),
            "",
            *_seen(held),
            "",
            "| channel | coding | KiB a frame | unit |",
            "| --- | --- | ---: | --- |",
            *channels,
            "",
            "`episodes/SEED/frames.parquet`, `objects.parquet` and `standing.parquet` hold the rest of the truth: a "
            "row a frame, an object a frame, and a parked or moored one that is seen a frame; channels lie in "
            "`pixels-*.tar` at the places that `frames.parquet` says.",
            f"`{MANIFEST}` has the size and the SHA-256 of each file; `frameout verify` checks them.",
            "",
            "| field | table | unit | coding |",
            "| --- | --- | --- | --- |",
            *fields,
            COORDINATES,
        ]
    )


def _held(found: dict[str, Any]) -> Iterator[str]:
    """Yield a table of what the objects do."""
    yield "| objects | share in, partial, occluded, out, absent (%) | frame-outs | frames of one: median, longest |"
    yield "| --- | --- | ---: | --- |"
    for group, shares in found["states"].items():
        outs = found["frame_outs"].get(group, {})
        percent = ", ".join(f"{100 * shares.get(s, 0.0):.1f}" for s in ("in", "partial", "occluded", "out", "absent"))
        lengths = ", ".join(f"{outs[level]:g}" for level in ("median", "most") if outs.get(level) is not None)
        yield f"| {group} | {percent} | {outs.get('count', 0)} | {lengths} |"


def _seen(found: dict[str, Any]) -> Iterator[str]:
    """Yield a table of what pictures show."""
    yield f"| seen in pictures | {TARGET} | {OTHERS} | {STANDING}: parked, moored |"
    yield "| --- | ---: | ---: | ---: |"
    for kind, groups in found["seen"].items():
        yield f"| {kind} | " + " | ".join(str(groups.get(group, 0)) for group in (TARGET, OTHERS, STANDING)) + " |"


def _unit(told: dict[str, Meaning], channel: str) -> str:
    return told[channel].unit if channel in told else _UNITS.get(channel, "")
