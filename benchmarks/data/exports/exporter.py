"""Exports of data sets: what all formats share, and their registry.

A format is a class with a docstring in a module of this folder, or in a module of a user's own::

    @export_format("boxes")
    class Boxes(Exporter):
        channels = ("image_rgb",)

        def write_episode(self, episode):
            for stored in self.frames(episode):
                ...
"""

from __future__ import annotations

import importlib
import inspect
import pkgutil
from collections.abc import Callable, Iterable, Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import ClassVar, TypeVar

import numpy as np
from numpy.typing import NDArray

from benchmarks.contract.text import counted, ranges_text
from benchmarks.data import sequence_names
from benchmarks.data.exports.destination import README, whole_folder
from benchmarks.data.exports.labels import ClassLevel, Instance, Labels, StoredFrame
from benchmarks.data.sets.card import axes_text, hub_head, tasks_of
from benchmarks.data.sets.channels import CODINGS, LOSSY, PICTURES, coding_of
from benchmarks.data.sets.data_set import DataSet
from benchmarks.data.sets.request import FORMAT
from benchmarks.data.sets.stored_episode import StoredEpisode
from benchmarks.data.sets.verifying import damaged
from benchmarks.run.packages import check_packages
from benchmarks.show.page import page_environment
from sim.checks import check, check_choice
from trackers.types import CameraModel


class Exporter:
    """Writes a data set in one file layout that other programs read.

    The docstring of a format is the text of the README.md beside its files: source of the format, axes, units, what the
    export decides.

    Attributes:
        channels: that must be stored, and are what it writes; none: it writes all that are.
        reads: those channels whose pixels ``frames`` reads, by default those of ``channels`` that are no pictures.
        packages: that writing needs, by their import names. extra: that installs them.
        data_files: pattern of the files of a ``{split}``, if the Hugging Face library ``datasets`` reads them; else ''.
        has_classes: whether it labels objects with classes, those too that only stand about.
        leaves_out: whether objects can be left out or marked as ignored, see ``Labels.takes``.
        of_stills: whether its readers take pictures one by one: then of those without a labelled object only the share
            is written that the set asks for (``Request.negatives``). Sequences are always whole.
        has_attributes: whether ``Instance.attributes`` are among its files.
        data: the set. folder: an empty one of this machine. labels: of its objects.
        ending: of exported pictures, with a dot: they are copied as PNG or JPEG, others become PNG.
        stack: holds the files that stay open until the last episode is written.
    """

    channels: ClassVar[tuple[str, ...]] = ()
    packages: ClassVar[tuple[str, ...]] = ()
    extra: ClassVar[str] = "data"
    data_files: ClassVar[str] = ""
    has_classes: ClassVar[bool] = False
    leaves_out: ClassVar[bool] = False
    of_stills: ClassVar[bool] = False
    has_attributes: ClassVar[bool] = False

    def __init__(self, data: DataSet, folder: Path, labels: Labels) -> None:
        self.data, self.folder, self.labels = data, folder, labels
        self.reads = tuple(channel for channel in self.channels if channel not in PICTURES)
        self.stack = ExitStack()
        self._written: dict[str, NDArray[np.int64]] = {}
        stored_as = coding_of("image_rgb", data.request.pictures)
        self._coding = stored_as if stored_as in ("png", LOSSY) else "png"
        self.ending = f".{CODINGS[self._coding].extension}"

    def write(self) -> None:
        """Write all files. Raises ValueError for a set that lacks what the format needs."""
        with self.stack:
            self.begin()
            for seed in self.data.seeds:
                self.write_episode(self.data.episode(seed))
            # ``_written`` is empty where all pictures are written.
            some = not self._written or any(counts.any() for counts in self._written.values())
            asked = f"none, with classes {', '.join(self.labels.names)} and negatives {self.data.request.negatives:g}"
            check("data", some, "pictures to write", asked)
            self.end()

    def begin(self) -> None:
        """Write what comes before the first episode."""

    def write_episode(self, episode: StoredEpisode) -> None:
        """Write the files of one episode."""
        raise NotImplementedError

    def end(self) -> None:
        """Write what comes after the last episode."""

    def frames(self, episode: StoredEpisode) -> Iterator[StoredFrame]:
        """Yield the frames of an episode, with the pixels of ``reads``; see ``of_stills``."""
        chosen = self._chosen(episode) if self.of_stills and self.data.request.negatives < 1 else range(len(episode))
        for index in chosen:
            yield self._frame(episode, index, self.reads)

    def _frame(self, episode: StoredEpisode, index: int, channels: tuple[str, ...]) -> StoredFrame:
        boxes = (episode.visible_boxes_of(index, table) for table in ("objects", "standing"))
        return StoredFrame(episode, index, episode.frame(index, channels), *boxes)

    def _chosen(self, episode: StoredEpisode) -> list[int]:
        """Return the frames with a labelled object, and as many others, evenly spread, as keep their share in what has
        been written of the episode's split.
        """
        frames = (self._frame(episode, index, ()) for index in range(len(episode)))
        is_positive = np.array([any(self._is_labelled(each) for each in self.labels.instances(one)) for one in frames])
        written = self._written.setdefault(self.data.request.split_of(episode.seed), np.zeros(2, np.int64))
        written[1] += is_positive.sum()
        share, others = self.data.request.negatives, np.flatnonzero(~is_positive)
        room = int(share / (1.0 - share) * written[1] + 1e-9 - written[0])
        kept = others[np.linspace(0, len(others) - 1, min(max(room, 0), len(others))).round().astype(int)]
        written[0] += len(kept)
        return sorted([*np.flatnonzero(is_positive).tolist(), *kept.tolist()])

    def _is_labelled(self, instance: Instance) -> bool:
        return instance.is_seen and self.labels.takes(instance)

    def name_of(self, episode: StoredEpisode) -> str:
        """Return the name of an episode's sequence, see ``sequence_name``."""
        return sequence_name(self.data, episode.seed)

    def picture(self, episode: StoredEpisode, index: int, channel: str = "image_rgb") -> bytes | None:
        """Return the content of a picture's file: as stored, or as PNG. None if the frame has none."""
        stored = episode.coded(index, channel)
        if stored is None:
            return None
        coding, content = stored
        return content if coding == self._coding else CODINGS[self._coding].encode(CODINGS[coding].decode(content))

    def black_picture(self, camera: CameraModel) -> bytes:
        """Return the content of the file of a picture that is black all over."""
        return CODINGS[self._coding].encode(np.zeros((camera.height_px, camera.width_px, 3), np.uint8))

    def place(self, path: str) -> Path:
        """Return a path in the folder, of which the folders above exist."""
        target = self.folder / path
        target.parent.mkdir(parents=True, exist_ok=True)
        return target

    def write_picture(self, stored: StoredFrame, path: str) -> None:
        """Write the frame's picture, if it has one, to a path in the folder, which lacks its ending."""
        content = self.picture(stored.episode, stored.index)
        if content is not None:
            self.place(path + self.ending).write_bytes(content)

    def write_lines(self, path: str, lines: Iterable[str]) -> None:
        """Write a text file in the folder."""
        self.place(path).write_text("".join(f"{line}\n" for line in lines), encoding="utf-8")


_FORMATS: dict[str, type[Exporter]] = {}
_Format = TypeVar("_Format", bound=type[Exporter])


def export_format(name: str) -> Callable[[_Format], _Format]:
    """Return a decorator that registers an ``Exporter`` under a name.

    Raises:
        ValueError: for a name that is taken, or a class without ``write_episode`` or a docstring, its README.
    """

    def register(exporter: _Format) -> _Format:
        ours = exporter.__module__.startswith(f"{__package__}.")
        known = _FORMATS if ours else formats()
        check("format", name not in known, "a name that no format has", repr(name))
        writes = exporter.write_episode is not Exporter.write_episode
        check("write_episode", writes, f"such a method of class {exporter.__name__}", "none")
        check("format", bool(exporter.__doc__), f"a docstring of class {exporter.__name__}, for its README", "none")
        _FORMATS[name] = exporter
        return exporter

    return register


def formats() -> dict[str, type[Exporter]]:
    """Return all formats by name, in order."""
    for module in pkgutil.iter_modules([str(Path(__file__).parent)]):
        importlib.import_module(f"{__package__}.{module.name}")
    return dict(sorted(_FORMATS.items()))


def set_name(data: DataSet) -> str:
    """Return a name for a data set, without dots: scenario, preset with what was changed in that, and a renderer."""
    request = data.request
    return sequence_names.set_name(request.scenario, request.preset, renderer=request.renderer)


def sequence_name(data: DataSet, seed: int) -> str:
    """Return a name for an episode: ``set_name`` and seed. Two of one name and edition show the same."""
    return sequence_names.sequence_name(set_name(data), seed)


def export(
    data: DataSet,
    name: str,
    out: str | Path,
    *,
    allow_incomplete: bool = False,
    classes: ClassLevel = "class",
    min_visible: float = 0.0,
    min_size_px: float = 0.0,
    ignore_standing: bool = False,
) -> int:
    """Write a data set into the folder or URL ``out`` in a format, see ``whole_folder``.

    Args:
        allow_incomplete: also of a data set in which episodes are missing that were asked for.
        classes, min_visible, min_size_px, ignore_standing: see ``Labels``.

    The set's own ``classes`` are labelled alone, and its ``negatives`` hold in formats of single pictures.

    Returns:
        the number of objects in pictures that were left out or marked as ignored.

    Raises:
        ValueError: for an unknown format, a missing package, a data set that lacks what the format needs, is
            incomplete, or whose files are not those that were written, or a folder that holds something or cannot be
            written.
    """
    known = formats()
    check_choice("format", name, known)
    chosen = known[name]
    check_packages(chosen.packages, chosen.extra)
    check("data", len(data.seeds) > 0, "a data set with episodes", f"{data.url} without any")
    stored = data.request.channels
    lacks = [channel for channel in chosen.channels if channel not in stored]
    check("data", not lacks, f"the channels {', '.join(chosen.channels)} for {name}", ", ".join(stored) or "none")
    missing = ranges_text(data.missing())
    whole = "all episodes (`frameout generate` makes those that are missing, --allow-incomplete does without)"
    check("data", allow_incomplete or not missing, whole, f"none of the seeds {missing}")
    labels = Labels(data, classes, min_visible, min_size_px, ignore_standing)
    new = f"a set of format {FORMAT}, with what only stands about (`frameout generate` into another folder makes it)"
    check("data", not chosen.has_classes or "standing" in data.tables, new, f"format {data.request.format}")
    check("classes", chosen.has_classes or classes == "class", f"class, since {name} has none", repr(classes))
    asked = (min_visible, min_size_px, ignore_standing)
    known_as = "min_visible min_size ignore_standing"
    check(known_as, chosen.leaves_out or not any(asked), f"none, since {name} holds all", asked)
    with whole_folder(str(out)) as folder:
        problem = next(damaged(data), None)
        check("data", problem is None, "a whole data set (see frameout verify)", problem)
        chosen(data, folder, labels).write()
        (folder / README).write_text(_readme(data, name, chosen, labels, folder), encoding="utf-8")
    return labels.left_out


def _readme(data: DataSet, name: str, chosen: type[Exporter], labels: Labels, folder: Path) -> str:
    # A split may have no picture, see ``Request.negatives``; readers refuse a pattern without a file.
    patterns = {split: chosen.data_files.format(split=split) for split in data.splits}
    splits = {split: [pattern] for split, pattern in patterns.items() if pattern and any(folder.glob(pattern))}
    template = page_environment(__file__, autoescape=False).get_template("README.md.jinja")
    channels = chosen.channels or data.request.channels
    tasks = dict.fromkeys(["object-detection"] * chosen.has_classes + tasks_of(channels))
    return template.render(
        head=hub_head(data, {name: splits} if chosen.data_files else {}, [*tasks]),
        name=name,
        data=data,
        chosen=chosen,
        labels=labels,
        few=counted(labels.left_out, "object"),
        ranges=ranges_text,
        text=inspect.getdoc(chosen),
        axes=axes_text(channels),
        rates=", ".join(dict.fromkeys(f"{data.episode(seed).rate_hz:g}" for seed in data.seeds)),
    )
