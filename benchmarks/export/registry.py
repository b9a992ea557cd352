"""The export formats by name, and the export of a data set in one of them."""

from __future__ import annotations

import importlib
from pathlib import Path

from benchmarks.data_sets.data_set import DataSet
from benchmarks.export.destination import whole_folder
from benchmarks.export.export_format import ExportFormat
from benchmarks.export.objects import ClassLevel, Labels
from benchmarks.run.packages import check_packages
from sim.checks import check
from sim.choices import check_choice

_FORMATS = {
    "coco": "benchmarks.export.coco:COCO",
    "kitti-depth": "benchmarks.export.kitti:DEPTH",
    "kitti-flow": "benchmarks.export.kitti:FLOW",
    "kitti-stereo": "benchmarks.export.kitti:STEREO",
    "mot": "benchmarks.export.mot:MOT",
    "otb": "benchmarks.export.otb:OTB",
    "rerun": "benchmarks.export.rerun:RERUN",
    "tao-amodal": "benchmarks.export.tao_amodal:TAO_AMODAL",
    "vot": "benchmarks.export.vot:VOT",
    "webdataset": "benchmarks.export.web_dataset:WEB_DATASET",
    "yolo": "benchmarks.export.yolo:YOLO",
}
README = "README.md"


def format_names() -> tuple[str, ...]:
    """Return the names of all formats."""
    return tuple(_FORMATS)


def export_format(name: str) -> ExportFormat:
    """Return a format. Raises ValueError for an unknown name; lists the known ones."""
    check_choice("format", name, _FORMATS)
    module, _, attribute = _FORMATS[name].partition(":")
    found: ExportFormat = getattr(importlib.import_module(module), attribute)
    return found


def export(
    data: DataSet,
    name: str,
    out: Path,
    *,
    classes: ClassLevel = "class",
    min_visible: float = 0.0,
    min_size_px: float = 0.0,
) -> int:
    """Write a data set into the folder ``out`` in a format, wholly or not at all.

    Args:
        classes, min_visible, min_size_px: see ``Labels``.

    Returns:
        the number of objects in pictures that show less than was asked for.

    Raises:
        ValueError: for an unknown format, a missing package, a data set that lacks what the format needs, or a folder
            that holds something or cannot be written.
    """
    chosen = export_format(name)
    check_packages(chosen.packages, chosen.extra)
    check("data", len(data.seeds) > 0, "a data set with episodes", f"{data.url} without any")
    stored = data.request.channels
    lacks = [channel for channel in chosen.channels if channel not in stored]
    check("data", not lacks, f"the channels {', '.join(chosen.channels)} for {name}", ", ".join(stored) or "none")
    labels = Labels(data, classes, min_visible, min_size_px)
    least = (min_visible, min_size_px)
    check("min_visible min_size", chosen.leaves_out or not any(least), f"0, since {name} holds all", least)
    with whole_folder(out) as folder:
        chosen.write(data, folder, labels)
        (folder / README).write_text(_readme(data, name, chosen.note), encoding="utf-8")
    return labels.left_out


def _readme(data: DataSet, name: str, note: str) -> str:
    request = data.request
    first, end = request.seeds
    source = f"Episodes of {request.scenario}, preset {request.preset}, of the seeds {first} to {end - 1}."
    return f"# {name}\n\n{source}\n\n{note.strip()}\n"
