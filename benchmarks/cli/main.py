"""The command ``frameout``: selects the sub-command, parses its arguments and reports wrong ones in one line.

So it reports faults of users' own code in worker processes, e.g. of a street pattern, without joblib's traceback.
"""

from __future__ import annotations

import contextlib
import errno
import importlib
import importlib.metadata
import inspect
import io
import os
import re
import select
import shutil
import sys
import textwrap
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise, takewhile
from pathlib import Path
from typing import ClassVar, Protocol, get_args, get_type_hints

import tyro

from benchmarks.cli.printing import trackers_print_to_stderr
from benchmarks.run.arithmetic import missing_settings
from benchmarks.run.own_modules import ROOT, foreign_packages, is_users, load_modules
from sim.checks import check_choice, nearest, suggestion

_FRAME = re.compile(r'File "([^"]+)", line (\d+), in ')
"""A line of a traceback in text: file and line."""


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
        "export": ("benchmarks.cli.export:Export", "write a data set in the file layout of another benchmark"),
        "paper": ("benchmarks.cli.paper:Paper", "repeat a paper's experiment and compare with its table"),
        "generate": ("benchmarks.cli.generate:Generate", "make a data set: pictures with all their truth"),
        "verify": ("benchmarks.cli.verify:Verify", "check a data set: is it whole"),
        "play": ("benchmarks.cli.play:Play", "steer a camera by hand, scored like a controller"),
        "render": ("benchmarks.cli.render:Render", "write an episode as an MP4"),
        "report": ("benchmarks.cli.report:Report", "make the report of a result folder again from its rows"),
        "show": ("benchmarks.cli.show:Show", "make a page about a data set"),
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
_KINDS = {"N": "a whole number", "INT": "a whole number", "FLOAT": "a number"}
_WIDEST = 120
_FAILED = 1
_USAGE_ERROR = 2
_STOPPED = 130
_UNREAD = 141
_OF_THE_DISK = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EROFS, errno.EACCES, errno.EPERM, errno.EIO)
"""A full disk, a full quota, a file at the size limit; a disk or a folder that may only be read; a broken disk."""
_ABOUT_AN_ARGUMENT = re.compile(r"[^\n]+: expected .*", re.DOTALL)


def main(arguments: Sequence[str] | None = None, program: Program = FRAMEOUT) -> int:
    """Run a command line; return the exit status.

    It is 0, 1 after a failure, 2 for wrong arguments, 130 after Ctrl-C, and 141 if the reader of stdout has left.
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
    if sys.platform == "win32":
        # It has no poll.
        return True
    stdout = select.poll()
    stdout.register(sys.stdout.fileno(), 0)
    return any(event & select.POLLERR for _, event in stdout.poll(0))


def _run(program: Program, arguments: Sequence[str] | None) -> int:
    if arguments is None:
        os.environ.update(missing_settings(os.environ))
    words = list(sys.argv[1:] if arguments is None else arguments)
    for package, place in foreign_packages().items():
        told = f"{package}: expected Frameout's package in {ROOT}, got {place}, which Python finds first"
        return _refuse(f"{told}; rename it, or start in another folder")
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
    name, rest = words[0], words[1:]
    try:
        check_choice("command", name, program.commands)
    except ValueError as error:
        return _refuse(str(error))
    command: Command | None = None
    try:
        command = _parsed(_kind(program, name), f"{program.name} {name}", rest)
        with trackers_print_to_stderr():
            load_modules(getattr(command, "modules", ()))
        return command.run()
    except ValueError as error:
        # Our own messages name the wrong parameter; any other error is a fault and keeps its traceback.
        if _ABOUT_AN_ARGUMENT.fullmatch(str(error)) is None:
            return _fault(error, command)
        return _refuse(str(error))
    except ChildProcessError as error:
        print(f"error: {error}", file=sys.stderr)
        return _FAILED
    except OSError as error:
        if error.errno not in _OF_THE_DISK:
            return _fault(error, command)
        where = "" if error.filename is None else f"{error.filename}: "
        print(f"error: {where}{error.strerror}; what was written before is kept", file=sys.stderr)
        return _FAILED
    except KeyboardInterrupt:
        resumable = command is not None and command.resumes
        print("stopped; the same command continues" if resumable else "stopped", file=sys.stderr)
        return _STOPPED
    except Exception as error:
        return _fault(error, command)


def _fault(error: Exception, command: Command | None) -> int:
    """Tell in one line what a user's own modules may have caused in a worker; raise any other error again."""
    told = workers_fault(error) if getattr(command, "modules", ()) else None
    if told is None:
        raise error
    print(f"error: {' '.join(told.split())}", file=sys.stderr)
    return _FAILED


class Command(Protocol):
    """A sub-command: a frozen dataclass of options.

    Attributes:
        resumes: whether the same command continues after an interruption.
    """

    resumes: ClassVar[bool]

    def run(self) -> int:
        """Run it; return the exit status."""
        ...


def _kind(program: Program, name: str) -> type[Command]:
    """Return the dataclass of a command."""
    module, _, kind = program.commands[name][0].partition(":")
    found: type[Command] = getattr(importlib.import_module(module), kind)
    return found


def _parsed(kind: type[Command], name: str, words: Sequence[str]) -> Command:
    """Return the command's dataclass, filled from the words. Raises ValueError for words that do not fit."""
    _check_lists(kind, words)
    complaint = io.StringIO()
    try:
        with contextlib.redirect_stderr(complaint):
            return tyro.cli(kind, args=words, prog=name, description=_description(kind), config=_STYLE)
    except SystemExit as stop:
        if not stop.code:
            raise
        raise ValueError(_in_one_line(complaint.getvalue(), name, words, kind)) from None


def _description(kind: type[Command]) -> str:
    """Return the docstring above its attributes in lines of the terminal's width, which tyro gives to options alone.

    Tyro joins lines that begin with a letter, so all but the first of a paragraph are indented.
    """
    paragraphs = inspect.cleandoc(kind.__doc__ or "").partition("\n\nAttributes:")[0].split("\n\n")
    width = min(shutil.get_terminal_size().columns, _WIDEST)
    wrapper = textwrap.TextWrapper(width, subsequent_indent="  ", break_on_hyphens=False)
    return "\n\n".join(map(wrapper.fill, paragraphs))


def _check_lists(kind: type[Command], words: Sequence[str]) -> None:
    """Raise ValueError for an option of several values that has none, which would count as not given."""
    hints = get_type_hints(kind)
    lists = {f"--{name.replace('_', '-')}" for name, hint in hints.items() if Ellipsis in get_args(hint)}
    for word, following in pairwise([*words, "--"]):
        name, _, value = word.replace("_", "-").partition("=")
        empty = not value if "=" in word else not following or following.startswith("--")
        if name in lists and empty and following != "--help":
            raise ValueError(f"{name.removeprefix('--')}: expected one value or more, got none")


def _hint(unknown: str, kind: type[Command]) -> str:
    """Return, in parentheses, what of a command was meant by an unknown option; else nothing."""
    hints = get_type_hints(kind, include_extras=True)
    # Without dashes, which all options have in common.
    near = nearest(unknown.strip("-").partition("=")[0].replace("-", "_"), hints)
    if near is None:
        return ""
    if tyro.conf.Positional in get_args(hints[near]):
        return f" (did you mean {near}, as words without an option?)"
    return f" (did you mean --{near.replace('_', '-')}?)"


def _given(option: str, words: Sequence[str]) -> str:
    """Return the values of an option, as they were typed: ``--option a b``, or ``--option=a b``; ``_`` is ``-``."""
    names = [word.replace("_", "-").partition("=")[0] for word in words]
    place = names.index(f"--{option}")
    joined = words[place].partition("=")[2]
    following = takewhile(lambda word: not word.startswith("--"), words[place + 1 :])
    return repr(" ".join([joined, *following]).strip())


def _in_one_line(complaint: str, name: str, words: Sequence[str], command: type[Command]) -> str:
    """Return tyro's boxed complaint as ``parameter: expected …, got …``."""
    lines = [re.sub(r"[│╭╮╰╯─]|^-+$", "", line.strip()).strip() for line in complaint.splitlines()]
    text = " ".join(line for line in lines if line)
    unparsed = re.search(r"Error parsing (--)?([\w.-]+).*: .*?(['\"].*['\"])", text)
    if unparsed:
        kind = re.search(r"Argument helptext: \S+ (\S+)", text)
        expected = _KINDS.get(kind[1], kind[1]) if kind else "another value"
        return f"{unparsed[2]}: expected {expected}, got {unparsed[3].split(' ')[0]}"
    pairs = re.search(r"Error parsing --([\w.-]+): Failed to parse key-value pairs", text)
    if pairs:
        wanted = "pairs of a name and a number, such as gain_per_s 0.8"
        return f"{pairs[1]}: expected {wanted}, got {_given(pairs[1], words)}"
    chosen = re.search(r"invalid choice '(\S*)' for argument '(?:--)?([\w.-]+)'. Expected one of \((.*?)\)", text)
    if chosen:
        known = re.findall(r"'(\S+?)'", chosen[3])
        return f"{chosen[2]}: expected one of {', '.join(known)}; got {chosen[1]!r}{suggestion(chosen[1], known)}"
    missing = re.search(rf"Missing from {name}: (--)?(\S+)", text)
    if missing:
        return f"{missing[2].lower()}: expected a value, got none"
    unknown = re.search(r"Unrecognized options: (\S+)", text)
    if unknown:
        given = unknown[1].rstrip(",")
        wanted = f"options of `{name} --help`"
        return f"arguments: expected {wanted}, got {given!r}{_hint(given, command)}"
    return f"arguments: expected those of `{name} --help`, got: {text}"


def _refuse(message: str) -> int:
    print(f"error: {' '.join(message.split())}", file=sys.stderr)
    return _USAGE_ERROR


def _overview(program: Program) -> str:
    width = max(map(len, program.commands))
    lines = [f"  {name:<{width}}  {summary}" for name, (_, summary) in program.commands.items()]
    return "\n".join([f"usage: {program.name} COMMAND …", "", program.about, "", *lines]) + program.ending


def workers_fault(error: BaseException) -> str | None:
    """Return an error of a worker process in one line, with the last line of a user's code on the way to it.

    None for an error of this process, or one without such a line.
    """
    cause = error.__cause__
    frames = _FRAME.findall(str(cause)) if type(cause).__name__ == "_RemoteTraceback" else []
    own = [frame for frame in frames if is_users(frame[0])]
    if not own:
        return None
    file, line = own[-1]
    return f"{Path(file).name}, line {line}: {type(error).__name__}: {error}"


if __name__ == "__main__":
    sys.exit(main())
