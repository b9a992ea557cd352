"""The command ``frameout``: selects the sub-command, which tyro fills, and reports wrong values in one line."""

from __future__ import annotations

import errno
import importlib
import importlib.metadata
import inspect
import os
import re
import select
import shutil
import sys
import textwrap
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar, Protocol

import tyro

from benchmarks.cli.printing import trackers_print_to_stderr
from benchmarks.run.arithmetic import missing_settings
from benchmarks.run.own_modules import load_modules
from sim.checks import check_choice


@dataclass(frozen=True)
class Program:
    """A command line with sub-commands.

    Attributes:
        name: what users type.
        commands: sub-command → ``module:class`` of the dataclass whose fields are its options, and what it does.
        about, ending: first and last lines of its help.
    """

    name: str
    commands: Mapping[str, tuple[str, str]]
    about: str
    ending: str = ""


FRAMEOUT = Program(
    "frameout",
    {
        "list": ("benchmarks.cli.list_all:List", "all that there is: scenarios, trackers, suites, envs, metrics"),
        "bench": ("benchmarks.cli.bench:Bench", "run a suite, rank the trackers, write rows, summary and report"),
        "compare": ("benchmarks.cli.compare:Compare", "paired differences of two trackers, by kind of event"),
        "score": ("benchmarks.cli.score:Score", "score predictions that were made elsewhere"),
        "export": ("benchmarks.cli.export:Export", "write a data set in the file layout of another benchmark"),
        "paper": ("benchmarks.cli.paper:Paper", "repeat a paper's experiment and compare with its table"),
        "generate": ("benchmarks.cli.generate:Generate", "make a data set: pictures with all their truth"),
        "merge": ("benchmarks.cli.merge:Merge", "make one data set of what several jobs have made"),
        "verify": ("benchmarks.cli.verify:Verify", "check a data set: is it whole"),
        "play": ("benchmarks.cli.play:Play", "steer a camera by hand, scored like a controller"),
        "render": ("benchmarks.cli.render:Render", "write an episode as an MP4"),
        "report": ("benchmarks.cli.report:Report", "make the report of a result folder again from its rows"),
        "rollout": ("benchmarks.cli.rollout:Rollout", "make a data set of what a controller does in an env"),
        "track": ("benchmarks.cli.track:Track", "run a tracker on your own video, write an overlay and estimates"),
        "train": ("benchmarks.cli.train:Train", "train a policy that steers by a tracker's estimate"),
        "tune": ("benchmarks.cli.tune:Tune", "search parameters of trackers and controllers"),
    },
    "Visual trackers whose target leaves the picture: simulate, run, score, report.",
    """

`frameout COMMAND --help` explains each command, `frameout --version` says which
Frameout this is.
Start with: frameout bench --quick""",
)
_STYLE = (tyro.conf.FlagCreatePairsOff, tyro.conf.PositionalMetavarFromFieldName)
_WIDEST = 120
_FAILED = 1
_USAGE_ERROR = 2
_STOPPED = 130
_UNREAD = 141
_OF_THE_DISK = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EROFS, errno.EACCES, errno.EPERM, errno.EIO)
"""A full disk, a full quota, a file at the size limit; a disk or a folder that may only be read; a broken disk."""
_ABOUT_AN_ARGUMENT = re.compile(r"[^\n]+: expected .*", re.DOTALL)


class Command(Protocol):
    """A sub-command: a frozen dataclass of options.

    Attributes:
        resumes: whether the same command continues after an interruption.
    """

    resumes: ClassVar[bool]

    def run(self) -> int:
        """Run it; return the exit status."""
        ...


def main(arguments: Sequence[str] | None = None, program: Program = FRAMEOUT) -> int:
    """Run a command line; return the exit status.

    It is 0, 1 after a failure, 2 for wrong arguments, 130 after Ctrl-C, and 141 if the reader of stdout has left.

    Raises:
        SystemExit: after the help of a command, and for arguments that are none of its options.
    """
    try:
        try:
            return _run(program, arguments)
        finally:
            sys.stdout.flush()
    except BrokenPipeError:
        if not _reader_has_left():
            raise
        # Whoever reads has seen enough, as ``head`` does. What is still to be written at the exit goes nowhere.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return _UNREAD


def _reader_has_left() -> bool:
    stdout = select.poll()
    stdout.register(sys.stdout.fileno(), 0)
    return any(event & select.POLLERR for _, event in stdout.poll(0))


def _run(program: Program, arguments: Sequence[str] | None) -> int:
    if arguments is None:
        os.environ.update(missing_settings(os.environ))
    words = list(sys.argv[1:] if arguments is None else arguments)
    try:
        importlib.import_module("scenarios")
    except ImportError as error:
        return _refuse(str(error))
    if words == ["--version"]:
        print(f"frameout {importlib.metadata.version('frameout')}")
        return 0
    if not words or words[0] in ("-h", "--help"):
        print(_overview(program))
        return 0 if words else _USAGE_ERROR
    name, *rest = words
    command: Command | None = None
    try:
        check_choice("command", name, program.commands)
        command = _parsed(_kind(program, name), f"{program.name} {name}", rest)
        with trackers_print_to_stderr():
            load_modules(getattr(command, "modules", ()))
        return command.run()
    except ValueError as error:
        # Our own messages name the wrong parameter; any other error is a fault and keeps its traceback.
        if _ABOUT_AN_ARGUMENT.fullmatch(str(error)) is None:
            raise
        return _refuse(str(error))
    except ChildProcessError as error:
        print(f"error: {error}", file=sys.stderr)
        return _FAILED
    except OSError as error:
        if error.errno not in _OF_THE_DISK:
            raise
        where = "" if error.filename is None else f"{error.filename}: "
        print(f"error: {where}{error.strerror}; what was written before is kept", file=sys.stderr)
        return _FAILED
    except KeyboardInterrupt:
        resumable = command is not None and command.resumes
        print("stopped; the same command continues" if resumable else "stopped", file=sys.stderr)
        return _STOPPED


def _kind(program: Program, name: str) -> type[Command]:
    """Return the dataclass of a command."""
    module, _, kind = program.commands[name][0].partition(":")
    found: type[Command] = getattr(importlib.import_module(module), kind)
    return found


def _parsed(kind: type[Command], name: str, words: Sequence[str]) -> Command:
    """Return the command's dataclass, filled from the words."""
    # Tyro wraps the texts of options alone. It joins lines that begin with a letter, so all but the first are indented.
    width = min(shutil.get_terminal_size().columns, _WIDEST)
    wrapper = textwrap.TextWrapper(width, subsequent_indent="  ", break_on_hyphens=False)
    paragraphs = inspect.cleandoc(kind.__doc__ or "").partition("\n\nAttributes:")[0].split("\n\n")
    description = "\n\n".join(map(wrapper.fill, paragraphs))
    return tyro.cli(kind, args=words, prog=name, description=description, config=_STYLE)


def _refuse(message: str) -> int:
    print(f"error: {' '.join(message.split())}", file=sys.stderr)
    return _USAGE_ERROR


def _overview(program: Program) -> str:
    width = max(map(len, program.commands))
    lines = [f"  {name:<{width}}  {summary}" for name, (_, summary) in program.commands.items()]
    return "\n".join([f"usage: {program.name} COMMAND …", "", program.about, "", *lines]) + program.ending


if __name__ == "__main__":
    sys.exit(main())
