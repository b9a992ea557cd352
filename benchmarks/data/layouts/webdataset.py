"""WebDataset as our export writes it: tar files, in which ``NAME_000000.png`` and ``NAME_000000.json`` are a sample.

https://github.com/webdataset/webdataset, and ``benchmarks.data.exports.web_dataset``: the JSON file holds the truth, an
entry of ``objects`` each with its name (``names``), ``state``, ``box_xyxy`` and ``visible_box_xyxy``, and the time.
Samples whose keys differ in the last number are a sequence. One target of each is followed by its name, see
``layouts.followed``: by default the one of which a pixel is seen in most pictures. The box around the whole target
counts where at least one pixel of it is seen, and its state says why there is none.
"""

from __future__ import annotations

import tarfile
from collections.abc import Iterator, Sequence
from functools import partial
from pathlib import Path, PurePosixPath
from typing import Any

import numpy as np

from benchmarks.data.coco_json import read_json
from benchmarks.data.layouts.followed import followed
from benchmarks.data.layouts.layout import Source, Target, layout
from benchmarks.data.pictures import ENDINGS, Member, short, visible
from benchmarks.data.read_once import read_once
from benchmarks.data.sequences import OCCLUDED, OUT, UNSEEN, Labelled
from sim.checks import check

_NONE = -1e9
"""What stands for no number."""
_WORDS = {"out": OUT, "absent": OUT, "occluded": OCCLUDED, "partial": "", "in": ""}
"""State → tag: a box that the border cuts tells so itself."""
Sample = dict[str, Member]


@layout("webdataset", "*.tar with NAME_000000.json beside pictures, as our export writes them")
def find_webdataset(path: Path) -> Iterator[Source]:
    """See ``Find``."""
    sequences: dict[str, list[Sample]] = {}
    for tar in visible(path, "*.tar"):
        for key, sample in _samples(tar).items():
            if ".json" in sample and any(ending in sample for ending in ENDINGS):
                sequences.setdefault(key.rpartition("_")[0], []).append(sample)
    for name, samples in sequences.items():
        places = dict.fromkeys(sample[".json"].tar for sample in samples)
        yield Source(name, (*places,), partial(_read, name, samples))


@read_once
def _samples(tar: Path) -> dict[str, Sample]:
    """Return key → ending → file, in the order of the tar file. Raises ValueError for a file that is none."""
    found: dict[str, Sample] = {}
    try:
        with tarfile.open(tar, "r:") as content:
            for each in content:
                key, _, ending = PurePosixPath(each.name).name.partition(".")
                found.setdefault(key, {})[f".{ending}"] = Member(tar, each.name, each.offset_data, each.size)
    except tarfile.TarError as error:
        raise ValueError(f"{short(tar)}: expected a tar file, got {error}") from None
    return found


def _read(name: str, samples: Sequence[Sample], target: Target) -> Labelled:
    truths = [_truth(sample[".json"]) for sample in samples]
    pictures = [next(sample[ending] for ending in ENDINGS if ending in sample) for sample in samples]
    file = pictures[0].tar
    seen = [each["names"] for truth in truths for each in truth["objects"] if target is not None or _is_seen(each)]
    chosen, _ = followed(target, file, seen)
    boxes, tags = np.full((len(samples), 4), np.nan), np.full(len(samples), UNSEEN, "<U10")
    for k, truth in enumerate(truths):
        for each in truth["objects"]:
            if each["names"] == chosen:
                tags[k] = _WORDS.get(each["state"], "") or ("" if _is_seen(each) else OCCLUDED)
                boxes[k] = each["box_xyxy"] if _is_seen(each) and min(each["box_xyxy"]) > _NONE else np.nan
    times_s = [truth["time_s"] for truth in truths]
    rate_hz = (len(times_s) - 1) / (times_s[-1] - times_s[0]) if times_s[-1] > times_s[0] else 0.0
    return Labelled(f"{name}-{chosen}", file, pictures, boxes, tags, whole=True, rate_hz=float(f"{rate_hz:.9g}"))


def _is_seen(entry: dict[str, Any]) -> bool:
    return bool(min(entry["visible_box_xyxy"]) > _NONE)


def _truth(member: Member) -> dict[str, Any]:
    """Return the truth of a sample. Raises ValueError for a file that is none of our export's."""
    truth = read_json(member)
    try:
        good = isinstance(truth["time_s"], float | int)
        for each in truth["objects"]:
            good &= isinstance(each["names"], str) and isinstance(each["state"], str)
            good &= np.array([each["box_xyxy"], each["visible_box_xyxy"]], float).shape == (2, 4)
    except (ValueError, KeyError, TypeError, OverflowError):
        good = False
    check(short(member), good, "truth as `frameout export --format webdataset` writes it", "something else")
    return dict(truth)
