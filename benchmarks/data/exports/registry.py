"""The export formats by name, and the export of a data set in one of them."""

from __future__ import annotations

import importlib
from pathlib import Path

from benchmarks.contract.text import counted, ranges_text
from benchmarks.data.exports.destination import README, whole_folder
from benchmarks.data.exports.export_format import ExportFormat
from benchmarks.data.exports.objects import ClassLevel, Labels
from benchmarks.data.sets.card import COORDINATES, hub_head, split_of
from benchmarks.data.sets.data_set import DataSet
from benchmarks.data.sets.request import FORMAT
from benchmarks.data.sets.verifying import damaged
from benchmarks.run.packages import check_packages
from sim.checks import check
from sim.choices import check_choice

_FORMATS = {
    "coco": "benchmarks.data.exports.coco:COCO",
    "kitti-depth": "benchmarks.data.exports.kitti:DEPTH",
    "kitti-flow": "benchmarks.data.exports.kitti:FLOW",
    "kitti-stereo": "benchmarks.data.exports.kitti:STEREO",
    "mot": "benchmarks.data.exports.mot:MOT",
    "otb": "benchmarks.data.exports.otb:OTB",
    "rerun": "benchmarks.data.exports.rerun:RERUN",
    "tao-amodal": "benchmarks.data.exports.tao_amodal:TAO_AMODAL",
    "vot": "benchmarks.data.exports.vot:VOT",
    "webdataset": "benchmarks.data.exports.web_dataset:WEB_DATASET",
    "yolo": "benchmarks.data.exports.yolo:YOLO",
}


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
    out: str | Path,
    *,
    allow_incomplete: bool = False,
    classes: ClassLevel = "class",
    min_visible: float = 0.0,
    min_size_px: float = 0.0,
) -> int:
    """Write a data set into the folder or URL ``out`` in a format, see ``whole_folder``.

    Args:
        allow_incomplete: also of a data set in which episodes are missing that were asked for.
        classes, min_visible, min_size_px: see ``Labels``.

    Returns:
        the number of objects in pictures that show less than was asked for.

    Raises:
        ValueError: for an unknown format, a missing package, a data set that lacks what the format needs, is
            incomplete, or whose files are not those that were written, or a folder that holds something or cannot be
            written.
    """
    chosen = export_format(name)
    check_packages(chosen.packages, chosen.extra)
    check("data", len(data.seeds) > 0, "a data set with episodes", f"{data.url} without any")
    stored = data.request.channels
    lacks = [channel for channel in chosen.channels if channel not in stored]
    check("data", not lacks, f"the channels {', '.join(chosen.channels)} for {name}", ", ".join(stored) or "none")
    missing = ranges_text(data.missing())
    whole = "all episodes (`frameout generate` makes those that are missing, --allow-incomplete does without)"
    check("data", allow_incomplete or not missing, whole, f"none of the seeds {missing}")
    labels = Labels(data, classes, min_visible, min_size_px)
    new = f"a set of format {FORMAT}, with what only stands about (`frameout generate` into another folder makes it)"
    check("data", not chosen.has_classes or "standing" in data.tables, new, f"format {data.request.format}")
    check("classes", chosen.has_classes or classes == "class", f"class, since {name} has none", repr(classes))
    least = (min_visible, min_size_px)
    check("min_visible min_size", chosen.leaves_out or not any(least), f"0, since {name} holds all", least)
    with whole_folder(str(out)) as folder:
        problem = next(damaged(data), None)
        check("data", problem is None, "a whole data set (see frameout verify)", problem)
        chosen.write(data, folder, labels)
        (folder / README).write_text(_readme(data, name, chosen, labels), encoding="utf-8")
    return labels.left_out


def _readme(data: DataSet, name: str, chosen: ExportFormat, labels: Labels) -> str:
    request, missing = data.request, data.missing()
    source = f"Episodes of {request.scenario}, preset {request.preset}, of the seeds {ranges_text(data.seeds)}."
    if missing:
        source += f" Missing, though asked for: the seeds {ranges_text(missing)}."
    if data.left_out:
        source += f" Left out, since they could not be built: the seeds {ranges_text(data.left_out)}."
    if chosen.has_classes:
        source += f"\n\nMade with `--classes {labels.level}`."
    if chosen.leaves_out:
        least = f"`--min-visible {labels.min_visible:g} --min-size {labels.min_size_px:g}`"
        source += f" {counted(labels.left_out, 'object')} of single pictures below {least}."
    splits = {split_of(seed): [chosen.data_files.format(split=split_of(seed))] for seed in data.seeds}
    head = hub_head(data, {name: splits} if chosen.data_files else {})
    return f"{head}# {name}\n\n{source}\n\n{chosen.note.strip()}\n{COORDINATES}"
