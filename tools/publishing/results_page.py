"""RESULTS.md and the pages of docs/results, made from their templates and the published tables.

``RESULTS.template.md``, here, gives RESULTS.md; ``docs/results/NAME.template.md`` gives NAME.md beside it. A template
is prose with calls in double braces (Jinja's):

================================================  ======================================================================
``table(NAME, …, columns=[…])``                  a line for each tracker with a number in the columns, the best in
                                                 the first column first, and below them those that are blind or oracles;
                                                 several tables stand below each other; by default the suite's headline
                                                 metrics
``paper(NAME)``                                  a paper's claims beside our figures
``agreed(NAME)``                                 ``3 of 4``: how many of the paper's claims our figures agree with
``fitted(EXPERIMENT)``                           what of it was set so that it agrees, in its own words
``value(NAME, TRACKER, METRIC)``                 ``94.2 (89.3–98.3)``: a number with its interval, fractions in per cent
``difference(NAME, TRACKER, OTHER, METRIC)``     the same of a paired difference
``origin(NAME, …)``                             the line below a table, for one that a template writes itself
================================================  ======================================================================

TRACKER and OTHER are names of trackers, or CONTROLLER+TRACKER. The line below a table names its command, seeds, commit
and editions, which may be others than those of the next table.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, replace
from functools import cache
from pathlib import Path
from typing import Any

from jinja2 import Environment, StrictUndefined, TemplateError

from benchmarks.contract.suite import suite
from benchmarks.contract.text import interval_text, number_text, unit_sign
from benchmarks.papers.experiment import experiment_named
from benchmarks.show.tables import NO_NUMBER, REFERENCES, UNRANKED_ROLES, Cell, leaderboard, markdown_table
from benchmarks.statistics.summary import paired
from sim.checks import check
from tools.publishing import ledger
from tools.publishing.table_files import TableFile, label, read_rows_of, read_table

_SHOWN_PARTS = ("tracker", "controller")
"""Parts of editions: a name, its edition and a digest."""


def results_pages() -> dict[Path, str]:
    """Return the text of each page by its path.

    Raises:
        ValueError: for a template that cannot be read, an unknown table, tracker or metric, and for one table of
            several seeds or budgets.
    """
    folder = ledger.RESULTS.parent / "docs" / "results"
    templates = {ledger.RESULTS: ledger.TEMPLATE} | {
        each.with_name(each.name.replace(".template", "")): each for each in sorted(folder.glob("*.template.md"))
    }
    page = _Page()
    environment = Environment(undefined=StrictUndefined, keep_trailing_newline=True, autoescape=False)
    calls = (page.table, page.paper, page.agreed, page.fitted, page.value, page.difference, page.origin)
    environment.globals |= {each.__name__: each for each in calls}
    pages = {}
    for path, template in templates.items():
        try:
            pages[path] = environment.from_string(template.read_text()).render()
        except TemplateError as error:
            raise ValueError(f"template: expected one that can be read, got {template.name}: {error}") from None
    return pages


class _Page:
    """The calls of the templates, see the module."""

    def __init__(self) -> None:
        self._read = cache(read_table)
        self._rows_of = cache(lambda name: [row for block in read_rows_of(name).values() for row in block])

    def table(self, *names: str, columns: Sequence[str] = ()) -> str:
        """See the module."""
        shown = [self._read(name) for name in names]
        check_one_run(shown)
        scores = suite(shown[0]["summary"][0]["suite"])
        # A metric that a suite does not have is named by its error.
        ranked = replace(scores, headline=tuple(scores.metric(name).name for name in columns) or scores.headline)
        boards = [
            leaderboard(ranked, each["summary"], sorted({entry["role"] for entry in each["summary"]})) for each in shown
        ]
        for name in columns:
            found = all(name in [column.name for column in board.columns] for board in boards)
            check("columns", found, f"metrics that {', '.join(names)} have", repr(name))
        # A headline metric that no row has, such as one of steered runs alone, has no column.
        kinds = sorted({" | ".join(column.head for column in board.columns) for board in boards})
        check("table", len(kinds) == 1, f"the same columns in {', '.join(names)}", "; ".join(kinds))
        several = len(shown) > 1
        lines: list[list[str]] = []
        beside: list[list[str]] = []
        for each, board in zip(shown, boards, strict=True):
            preset = [f"`{each['summary'][0]['preset']}`"] if several else []
            for line in board.lines:
                # A tracker without any number here, such as one of another protocol, has no line.
                if any(cell.text != NO_NUMBER for cell in line.cells):
                    (beside if line.role in UNRANKED_ROLES else lines).append([*preset, *line.words])
        texts = [*(["preset"] if several else []), *scores.key_columns, "role"]
        heads = [*texts, *(column.head for column in boards[0].columns)]
        if lines and beside:
            lines.append([f"*{REFERENCES}*", *[""] * (len(heads) - 1)])
        return f"{markdown_table(heads, lines + beside, words=len(texts))}\n\n{self.origin(*names)}"

    def paper(self, name: str) -> str:
        """See the module."""
        shown = self._read(name)
        check("paper", bool(shown["findings"]), "a table of a paper's experiment", repr(name))
        verdicts = {True: ": yes", False: ": no", None: ""}
        lines = []
        for found in shown["findings"]:
            method = f"`{found['tracker']}`" if found["tracker"] else ""
            minus = f" minus `{found['minus']}`" if found["minus"] else ""
            expected = f"{found['expected']}{verdicts[found['agrees']]}"
            lines.append([method + minus, found["counted"], found["paper"], _number(found, sign=True), expected])
        heads = ["method", "counted", "the paper", "here", "expected"]
        if not any(method for method, *_ in lines):
            heads, lines = heads[1:], [line[1:] for line in lines]
        return f"{markdown_table(heads, lines, words=len(heads))}\n\n{_varied(shown)}{self.origin(name)}"

    def agreed(self, name: str) -> str:
        """See the module."""
        findings = self._read(name)["findings"]
        # Aims of ours stand among the paper's claims, marked so.
        claims = (found for found in findings if "not in the paper" not in found["paper"])
        judged = [found["agrees"] for found in claims if found["agrees"] is not None]
        check("agreed", bool(judged), "a table with claims that can be judged", repr(name))
        return f"{sum(judged)} of {len(judged)}"

    def value(self, name: str, tracker: str, metric: str) -> str:
        """See the module."""
        found = [
            entry
            for entry in self._read(name)["summary"]
            if entry["metric"] == metric and tracker in (entry["tracker"], label({"controller": "", **entry}))
        ]
        check("value", len(found) == 1, f"one number of {tracker} in {metric} in {name}", len(found))
        return _number(found[0])

    def difference(self, name: str, tracker: str, other: str, metric: str) -> str:
        """See the module."""
        judged = suite(self._read(name)["summary"][0]["suite"]).metric(metric)
        own, others = ([row for row in self._rows_of(name) if label(row) == each] for each in (tracker, other))
        found = paired(own, others, judged)
        if found is None:
            both = f"{tracker} and {other} in {name}"
            raise ValueError(f"difference: expected rows with {metric} on common seeds of {both}, got none")
        return _number({**asdict(found), "mean": found.difference, "unit": judged.unit})

    def fitted(self, experiment: str) -> str:
        """See the module."""
        return experiment_named(experiment).fitted or "not said."

    def origin(self, *names: str) -> str:
        """See the module."""
        made: dict[str, list[str]] = {}
        for each in map(self._read, names):
            made.setdefault(f"seeds {each['seeds']}, commit {each['commit']}{_editions(each)}", []).append(
                each["table"]
            )
        origins = [f"{', '.join(of)}: {how}" if len(made) > 1 else how for how, of in made.items()]
        return f"Made by `python -m tools publish {' '.join(names)}`: {'; '.join(origins)}."


def check_one_run(shown: Sequence[TableFile]) -> None:
    """Raise ValueError for one table of several seeds, or with trackers or controllers that were tuned unequally."""
    names = ", ".join(each["table"] for each in shown)
    seeds = sorted({each["seeds"] for each in shown})
    check("table", len(seeds) == 1, f"one range of seeds in {names}", ", ".join(seeds))
    for kind in ("trackers", "controllers"):
        spent: dict[str, list[str]] = {}
        for each in shown:
            for name, budget in each["budgets"].get(kind, {}).items():
                spent.setdefault(", ".join(f"{key} {of}" for key, of in budget.items()), []).append(name)
        found = [f"{' '.join(sorted(set(of)))}: {budget}" for budget, of in spent.items()]
        check("table", len(found) <= 1, f"{kind} of {names} tuned with one budget", "; ".join(found))


def _number(entry: Mapping[str, Any], *, sign: bool = False) -> str:
    unit = entry["unit"]
    text = " ".join(filter(None, (number_text(entry["mean"], unit), unit_sign(unit) if sign else "")))
    interval = interval_text(entry["ci_low"], entry["ci_high"], unit)
    return str(Cell(text, interval))


def _varied(shown: TableFile) -> str:
    """Return the table of what was fitted, varied, and the words on it; nothing where a paper's table has none."""
    varied = shown.get("varied")
    if not varied:
        return ""
    return f"{varied['words']}\n\n{markdown_table(varied['heads'], varied['rows'], words=1)}\n\n"


def _editions(shown: TableFile) -> str:
    """Return the editions of a table's rows in words, without digests of parameters; nothing for one without rows."""
    editions = shown.get("editions")
    if not editions or not editions["scenes"]:
        return ""
    scenes = sorted({scene.split()[0] for scene in editions["scenes"].values()})
    made = (parts[part] for parts in editions["contestants"].values() for part in _SHOWN_PARTS if part in parts)
    raised = sorted({" ".join(each.split()[:2]) for each in made if each.split()[1] != "1"})
    others = ["all others 1"] if editions["contestants"] else []
    return f", editions {', '.join([*scenes, editions['shared']['judge'], *raised, *others])}"
