"""Folders of predictions: which trackers they hold, and their files for the episodes of a run.

A tracker's folder is named like it. It holds a text file for each sequence, see ``PLACES``, or, where a file of
annotations is given, one JSON file of results. A folder of such folders holds several trackers.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

from benchmarks.contract.suite import Suite
from benchmarks.contract.text import printable
from benchmarks.data.pictures import short
from benchmarks.data.predictions.formats import Predictions, SequenceFile, format_of, read_predictions, sequences_in
from benchmarks.data.predictions.predicted import Predicted
from benchmarks.run.episodes import EpisodeSpec
from sim.checks import check

_RUN = "_001.txt"
_EXPERIMENTS = ("baseline", "unsupervised", "realtime", "longterm")
PLACES = ("*.txt", "data/*.txt", f"*/*{_RUN}", *(f"{name}/*/*{_RUN}" for name in _EXPERIMENTS))
"""Of files in a tracker's folder: ``NAME.txt``, ``data/NAME.txt`` as TrackEval has it, and ``NAME/NAME_001.txt``, also
in the folder of an experiment, as the VOT toolkit has it.
"""
_WORDS = "NAME.txt, data/NAME.txt, NAME/NAME_001.txt, or with annotations one JSON file,"
_ELSEWHERE = "-elsewhere"
_FEW = 3


@dataclass(frozen=True)
class Folder:
    """A tracker's folder.

    Attributes:
        path: of the folder.
        annotations: file that the numbers of pictures in JSON results are of.
    """

    path: Path
    annotations: Path | None

    @cached_property
    def sequences(self) -> dict[str, Path]:
        """Sequence, or of JSON results folder of its pictures, → its file. Raises ValueError for several JSON files."""
        places = ("*.json", "data/*.json") if self.annotations is not None else ()
        results = sorted(path for place in places for path in self.path.glob(place))
        check(short(self.path), len(results) <= 1, "one JSON file of results", f"{len(results)} of them")
        if results:
            return dict.fromkeys(sequences_in(results[0], self.annotations), results[0])
        found: dict[str, Path] = {}
        for place in PLACES:
            for path in sorted(self.path.glob(place)):
                name = path.parent.name if place.endswith(_RUN) else path.stem
                if path.name in (f"{name}.txt", f"{name}{_RUN}") and path.is_file():
                    found.setdefault(printable(name), path)
        return found


def find_folders(
    paths: Sequence[Path], annotations: Path | None, is_wanted: Callable[[str], bool], example: str
) -> list[Folder]:
    """Return the trackers' folders among paths and in them.

    Args:
        is_wanted: takes a name: whether it is that of a sequence. example: such a name.

    Raises:
        ValueError: for a path that is no folder, or holds no prediction of a wanted sequence.
    """

    def trackers_in(candidates: Iterable[Path]) -> list[Folder]:
        folders = (Folder(each, annotations) for each in candidates)
        return [each for each in folders if any(map(is_wanted, each.sequences))]

    found: list[Folder] = []
    for path in paths:
        check("predictions", path.is_dir(), "folders that exist", repr(printable(path)))
        inside = sorted(path.resolve().iterdir())
        own = trackers_in([path.resolve()]) or trackers_in(filter(Path.is_dir, inside))
        wanted = f"{_WORDS} in {printable(path)} or in its folders, with a NAME such as {example}"
        some = ", ".join(printable(each.name) for each in inside[:_FEW]) or "nothing"
        check("predictions", bool(own), wanted, some)
        found += own
    return found


def predicted_trackers(
    suite: Suite,
    folders: Sequence[Folder],
    sequences: Sequence[tuple[EpisodeSpec, SequenceFile]],
    format: str,
    recorded: tuple[str, ...],
    taken: Collection[str],
) -> dict[str, Predicted]:
    """Return the trackers of folders, by name in rows. All of their files are read here once, so that what is wrong is
    said before anything runs.

    Args:
        sequences: episodes, and what is known of their files, without path and format.
        format: of ``FORMATS``; "" = each file's is recognised.
        recorded: see ``Predicted``.
        taken: names of trackers that run; a folder of such a name gets an ending.

    Raises:
        ValueError: for two trackers of one name, and a file that is broken, or that the suite cannot judge; names it.
    """
    trackers = {}
    for folder in folders:
        name = printable(folder.path.name)
        name += _ELSEWHERE if name in taken else ""
        check("predictions", name not in trackers, "trackers of different names", f"two called {name}")
        files, digests = {}, {}
        for episode, known in sequences:
            key = (episode.preset, episode.seed)
            path = folder.sequences.get(known.sequence, folder.sequences.get(known.folder))
            files[key], digests[key] = known, "none"
            if path is not None:
                form = format or format_of(path)
                files[key] = replace(known, path=path, format=form, annotations=folder.annotations)
                found = read_predictions(files[key])
                _check_kind(suite, path, found)
                digests[key] = found.digest
        trackers[name] = Predicted(name=name, suites=(suite.name,), files=files, digests=digests, recorded=recorded)
    return trackers


def _check_kind(suite: Suite, path: Path, found: Predictions) -> None:
    """Raise ValueError for predictions of one target, or without identities, in a suite of many."""
    many = found.tracks is not None or not suite.follows_many
    got = "a line a frame, as of one target" if found.regions is not None else "results without track_id"
    check(
        short(path, 3),
        many,
        f"tracks with identities (mot, or coco with track_id), as {suite.name} has many targets",
        got,
    )
