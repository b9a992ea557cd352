"""Trackers in processes of their own: what ``frameout bench --process`` names.

An argument is ``NAME=COMMAND``, or a TOML file with a table for each tracker::

    [mine]
    command = "python my_tracker.py --weights small.npz"
    suites = ["frame-out", "stereo"]

======================================  ================================================================================
key                                     meaning
======================================  ================================================================================
``command``                             its words, with quotes as in a shell; files and folders are found from where the
                                        TOML file lies. A Python file that begins it and says which packages it needs
                                        runs in an environment of its own, see ``trackers.clients.environments``; ours
                                        (``opencv_contrib.py``) are found by their names
``protocol``                            ``"folder"`` for a program of VOTS' folder protocol, which gets all pictures of
                                        an episode at once, see ``trackers.clients.folder``; others say in their
                                        greeting what they speak
``suites``                              suites that it is entered for; without it all
``summary``                             one line
``parameters``                          a table, for the tracker's ``parameters``
``environment``                         a table of further variables of its environment
``files``                               what its answers depend on beside the files that ``command`` names
``reproducible``                        false for a tracker that draws random numbers without the generator that it is
                                        given
``start_limit_s``                       longest wait for its greeting, with imports and weights, in seconds
``frame_limit_s``                       longest wait for an answer; without it ten times ``--limit-s``, which limits the
                                        CPU time of all its processes for an answer
``memory_limit_gb``                     most memory of all its processes; without it half of the machine's
======================================  ================================================================================

Rows have a digest of the files that a command names, of those under ``files`` and of the other keys.
"""

from __future__ import annotations

import hashlib
import json
import re
import shlex
import shutil
import tomllib
from collections.abc import Iterable, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.contract.rows import Row
from benchmarks.contract.suite import suites
from benchmarks.contract.tracker_spec import EpisodeName, TrackerSpec
from benchmarks.run.episodes import EpisodeSpec
from benchmarks.run.own_inputs import own
from scenarios.loop import FromPictures, LoopTracker, ManyFromPictures, first_box, given
from scenarios.scenario import Episode, Frame
from sim.checks import check, check_choice
from trackers import registry
from trackers.clients.child import Limits
from trackers.clients.environments import made_environment, needs
from trackers.clients.folder import answers_on
from trackers.clients.remote import Program, RemoteMultiTracker, RemoteTracker, found_program, remote_tracker
from trackers.clients.trax import TraxTracker
from trackers.follow_one import FollowOne
from trackers.protocols import MultiTracker, Tracker
from trackers.types import Estimate, Start

_NAME = re.compile(r"[A-Za-z_][\w.-]*")
_OF_FILES = re.compile(r"\S+\.(py|toml)")
_SUMMARY = "in a process of its own"
_LONGEST_PATH = 1000
_LARGEST = 1_000_000
_FOLDER = "folder"
_WALL = 10.0
"""Limit of wall time over that of CPU time, as in ``time_limit``."""


@dataclass(frozen=True)
class Served:
    """What the answers of a process depend on.

    Attributes:
        command: as it is written. contents: digest of the files.
        parameters, environment: see the module's docstring.
    """

    command: tuple[str, ...]
    contents: str
    parameters: Mapping[str, Any]
    environment: Mapping[str, str]


@dataclass(frozen=True, kw_only=True)
class ProcessTracker(TrackerSpec):
    """A tracker in a process of its own.

    Attributes:
        program: what is started. argument: of ``--process``, that names it.
    """

    parameters: Served
    program: Program
    argument: str

    @property
    def columns(self) -> Row:
        """See ``TrackerSpec``."""
        return {"process": self.argument}

    def create(
        self, named: EpisodeName, episode: Episode, rng: np.random.Generator, *, many: bool = False
    ) -> LoopTracker:
        """See ``TrackerSpec``."""
        if self.takes_all:
            check("tracker", not many, "one of many targets, with a method start", "one of VOTS' folder protocol")
            assert isinstance(named, EpisodeSpec)
            return _FromFolder(self.program, named)
        remote = remote_tracker(self.program, self.parameters.parameters, rng)
        if isinstance(remote, RemoteMultiTracker):
            if many:
                return _ManyFromProcess(remote, remote)
            start = own(episode.start)
            return _FromProcess(FollowOne(remote, start.background, start.site), remote)
        if many:
            remote.release(whole=False)
            raise ValueError("tracker: expected one of many targets, with a method start, got one of a single target")
        return _FromProcess(remote, remote)


class _FromProcess(FromPictures):
    def __init__(self, tracker: Tracker, remote: RemoteTracker | RemoteMultiTracker | TraxTracker) -> None:
        super().__init__(tracker)
        self._remote = remote

    def release(self, whole: bool) -> list[str]:
        """See ``ReleasedLoopTracker``."""
        return _released(self._remote, whole)


class _ManyFromProcess(ManyFromPictures):
    def __init__(self, tracker: MultiTracker, remote: RemoteMultiTracker) -> None:
        super().__init__(tracker)
        self._remote = remote

    def release(self, whole: bool) -> list[str]:
        """See ``ReleasedLoopTracker``."""
        return _released(self._remote, whole)


class _FromFolder:
    """Answers by what a program of the folder protocol has left: it gets another pass through the same episode."""

    def __init__(self, program: Program, named: EpisodeSpec) -> None:
        wanted = "one that answers picture by picture, as a controller steers by it"
        check("tracker", named.steering is None, wanted, "one of VOTS' folder protocol")
        with closing(named.open("target")) as episode:
            pictures = (episode.step().observation.image_rgb for _ in range(episode.frame_count))
            how = (program.command, dict(program.environment), program.limits)
            self._answers, self._cpu_s = answers_on(*how, pictures, lambda: first_box(episode.start))

    def initialise(self, frame: Frame, start: Start) -> Estimate:
        """See ``LoopTracker``."""
        return given(start)

    def update(self, frame: Frame) -> Estimate:
        """See ``LoopTracker``."""
        return self._answers[frame.truth.frame]

    def elsewhere_cpu_s(self) -> float:
        """See ``OutsourcingLoopTracker``: each picture's share."""
        return self._cpu_s

    def release(self, whole: bool) -> list[str]:
        """See ``ReleasedLoopTracker``."""
        return ["gets all pictures of an episode before its first answer"] if whole else []


def _released(remote: RemoteTracker | RemoteMultiTracker | TraxTracker, whole: bool) -> list[str]:
    return ["left processes alone that it had started; they were ended with it"] if remote.release(whole) else []


def process_trackers(arguments: Iterable[str], limit_s: float) -> dict[str, TrackerSpec]:
    """Return trackers by name, as arguments of ``--process`` name them.

    Args:
        limit_s: of CPU time for one answer.

    Raises:
        ValueError: for what is no such argument; names the key, what was expected and what came.
    """
    found: dict[str, TrackerSpec] = {}
    for argument in arguments:
        name, is_command, command = argument.partition("=")
        if is_command and _NAME.fullmatch(name):
            tables: Mapping[str, Any] = {name: {"command": command}}
            folder = Path.cwd()
        else:
            check("process", argument.endswith(".toml"), "NAME=COMMAND, or a TOML file", repr(argument))
            tables, folder = _tables_in(Path(argument)), Path(argument).absolute().parent
        for each, table in tables.items():
            check("process", each not in found, "each name once", f"{each!r} twice")
            check("process", _NAME.fullmatch(each) is not None, "names of letters, digits, _, - and .", repr(each))
            check("process", not _is_taken(each), "names that no tracker of `frameout list` has", each)
            found[each] = _tracker(each, table, folder, argument, limit_s)
    return found


def _is_taken(name: str) -> bool:
    references = (each.name for suite in suites().values() for each in suite.references)
    return registry.entry_or_none(name) is not None or name in references


def _tables_in(file: Path) -> Mapping[str, Any]:
    wanted = "a TOML file with a table for each tracker"
    try:
        tables = tomllib.loads(file.read_text("utf-8-sig"))
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        raise ValueError(f"process: expected {wanted}, got {str(file)!r}: {error}") from None
    check("process", bool(tables), wanted, f"none in {str(file)!r}")
    return tables


_KINDS: Mapping[str, tuple[type | tuple[type, ...], str]] = {
    "command": (str, "a command, in quotes"),
    "protocol": (str, "'folder', or none"),
    "suites": (list, "a list of suites"),
    "summary": (str, "a line of text"),
    "parameters": (dict, "a table"),
    "environment": (dict, "a table of texts"),
    "files": (list, "a list of files"),
    "reproducible": (bool, "true or false"),
    **dict.fromkeys(
        ("start_limit_s", "frame_limit_s", "memory_limit_gb"), ((int, float), f"a number > 0, at most {_LARGEST:,}")
    ),
}


def _tracker(name: str, table: Any, folder: Path, argument: str, limit_s: float) -> ProcessTracker:
    check("process", isinstance(table, Mapping), f"a table [{name}]", repr(table))
    for key, value in table.items():
        check_choice(f"process {name}", key, _KINDS)
        kind, words = _KINDS[key]
        good = isinstance(value, kind) and (kind is bool or not isinstance(value, bool))
        good = good and (not key.endswith(("_s", "_gb")) or 0 < value <= _LARGEST)
        texts = value.values() if good and key == "environment" else value if good and kind is list else ()
        good = good and all(isinstance(each, str) for each in texts) and (key != "protocol" or value == _FOLDER)
        check(f"process {name}: {key}", good, words, repr(value))
    check(f"process {name}", bool(table.get("command", "").strip()), "a command", "none")
    try:
        written = tuple(shlex.split(table["command"]))
    except ValueError as error:
        raise ValueError(f"process {name}: expected a command with closed quotes, got {error}") from None
    command = _command(name, written, folder)
    files = [found_program(written[0], folder), *(Path(_value(word)) for word in command[1:])]
    named = len(files)
    files += [folder / each for each in table.get("files", ())]
    for each in files[named:]:
        check(f"process {name}: files", each.is_file(), "files that exist", repr(str(each)))
    wanted = tuple(table.get("suites", ()))
    for each in wanted:
        check_choice(f"process {name}: suites", each, suites())
    environment, parameters = table.get("environment", {}), table.get("parameters", {})
    for each, value in environment.items():
        good = each != "" and not set(each) & {"=", "\0"} and "\0" not in value
        check(f"process {name}: environment", good, "names and values that a system takes", repr(f"{each}={value}"))
    try:
        json.dumps(parameters)
    except TypeError as error:
        raise ValueError(f"process {name}: parameters: expected what JSON has, got {error}") from None
    defaults = Limits(frame_s=_WALL * limit_s, frame_cpu_s=limit_s)
    limits = replace(
        defaults,
        start_s=float(table.get("start_limit_s", defaults.start_s)),
        frame_s=float(table.get("frame_limit_s", defaults.frame_s)),
        memory_gb=table.get("memory_limit_gb"),
    )
    return ProcessTracker(
        name=name,
        role="external",
        summary=table.get("summary", _SUMMARY),
        suites=wanted or tuple(suites()),
        parameters=Served(written, _digest(files), parameters, environment),
        module="",
        reproducible=table.get("reproducible", True),
        takes_all="protocol" in table,
        # All of its work is in its construction, for which it has its own limits.
        start_limit_s=_LARGEST if "protocol" in table else limits.start_s,
        frame_limit_s=limits.frame_s,
        program=Program(command, tuple(environment.items()), limits),
        argument=argument,
    )


def _command(name: str, written: Sequence[str], folder: Path) -> tuple[str, ...]:
    """Return a command as it is run, in an environment that it may need, with whole paths of files and folders."""
    first, rest = found_program(written[0], folder), [_found(word, folder) for word in written[1:]]
    if first.suffix == ".py" and first.is_file() and needs(first):
        return (str(made_environment(first)), str(first), *rest)
    program = shutil.which(first if first.is_file() else written[0])
    wanted = "a program, or a Python file that says which packages it needs (else begin with python)"
    check(f"process {name}", program is not None, wanted, repr(written[0]))
    # Other programs, e.g. of containers, have files of their own.
    if first.name.startswith("python"):
        for value in map(_value, written[1:]):
            exists = not _OF_FILES.fullmatch(value) or (folder / value).exists()
            check(f"process {name}", exists, "a program whose files exist", f"no file {value} in {folder}")
    return (str(Path(str(program)).absolute()), *rest)


def _found(word: str, folder: Path) -> str:
    """Return a word of a command with the whole path of a file or folder, as the process runs in another one."""
    value = _value(word)
    exists = value != "" and len(value) < _LONGEST_PATH and (folder / value).exists()
    return f"{word[: len(word) - len(value)]}{folder / value}" if exists else word


def _value(word: str) -> str:
    """Return the value of an option, ``--name=value``, else the word."""
    return word.partition("=")[2] if word.startswith("-") else word


def _digest(files: Iterable[Path]) -> str:
    digest = hashlib.sha256()
    for file in files:
        if file.is_file():
            with file.open("rb") as content:
                digest.update(hashlib.file_digest(content, "sha256").digest())
    return digest.hexdigest()[:16]
