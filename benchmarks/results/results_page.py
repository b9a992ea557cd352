"""RESULTS.md, made from its template and the published tables.

The template, ``RESULTS.template.md``, is prose with calls in double braces (Jinja's):

================================================  ======================================================================
``table(NAME, …, columns=[…], roles=[…])``       a line for each contestant with a number in the columns, the best in
                                                 the first column first; several tables stand below each other; by
                                                 default the suite's headline metrics, and all roles
``paper(NAME)``                                  a paper's claims beside our figures
``figures(NAME)``                                all metrics of a speed, a line for each
``value(NAME, CONTESTANT, METRIC)``              ``94.2 (89.3–98.3)``: a number with its interval, fractions in per cent
``difference(NAME, CONTESTANT, OTHER, METRIC)``  the same of a paired difference; of two pairs that differ in one name,
                                                 OTHER is that name if CONTESTANT is ours, else the pair
``change(NAME, OTHER, CONTESTANT, METRIC)``      the same of one contestant: table NAME minus OTHER, paired over
                                                 the seeds that both have
================================================  ======================================================================

A contestant is a tracker, or CONTROLLER+TRACKER. Tables end with a line that names their command, commit and seeds.
All that one page shows was made at one commit.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Any

from jinja2 import Environment, StrictUndefined, TemplateError

from benchmarks.report.markdown import head, markdown_table, names_and_cells, short
from benchmarks.report.numbers import interval_text, number_text, unit_sign
from benchmarks.report.tables import NO_NUMBER, leaderboard
from benchmarks.results import ledger
from benchmarks.results.table_files import TableFile, label, read_rows_of, read_table
from benchmarks.run.records import Row
from benchmarks.scores.summary import paired
from benchmarks.suites.registry import suite
from sim.checks import check


def results_page() -> str:
    """Return RESULTS.md.

    Raises:
        ValueError: for a template that cannot be read, an unknown table, contestant or metric, a table of several seeds
            or budgets, and tables of several commits.
    """
    page = _Page()
    environment = Environment(undefined=StrictUndefined, keep_trailing_newline=True, autoescape=False)
    calls = (page.table, page.paper, page.figures, page.value, page.difference, page.change)
    environment.globals |= {each.__name__: each for each in calls}
    try:
        text = environment.from_string(ledger.TEMPLATE.read_text()).render()
    except TemplateError as error:
        raise ValueError(f"template: expected one that can be read, got {ledger.TEMPLATE.name}: {error}") from None
    check_one_commit(page.tables.values())
    return text


class _Page:
    """The calls of the template, see the module.

    Attributes:
        tables: that they have read, by name.
    """

    def __init__(self) -> None:
        self.tables: dict[str, TableFile] = {}
        self._rows: dict[str, list[Row]] = {}

    def _read(self, name: str) -> TableFile:
        if name not in self.tables:
            self.tables[name] = read_table(name)
        return self.tables[name]

    def table(self, *names: str, columns: Sequence[str] = (), roles: Sequence[str] = ()) -> str:
        """See the module."""
        shown = [self._read(name) for name in names]
        check_one_run(shown)
        scores = suite(shown[0]["summary"][0]["suite"])
        # A metric that a suite does not have is named by its error.
        ranked = replace(scores, headline=tuple(scores.metric(name).name for name in columns) or scores.headline)
        boards = [
            leaderboard(ranked, each["summary"], roles or sorted({entry["role"] for entry in each["summary"]}))
            for each in shown
        ]
        for name in columns:
            found = all(name in [column.name for column in board.columns] for board in boards)
            check("columns", found, f"metrics that {', '.join(names)} have", repr(name))
        # A headline metric that no row has, such as one of steered runs alone, has no column.
        kinds = sorted({" | ".join(map(head, board.columns)) for board in boards})
        check("table", len(kinds) == 1, f"the same columns in {', '.join(names)}", "; ".join(kinds))
        several, lines = len(shown) > 1, []
        for each, board in zip(shown, boards, strict=True):
            preset = [f"`{each['summary'][0]['preset']}`"] if several else []
            # A contestant without any number here, such as one of another protocol, has no line.
            told = (line for line in board.lines if any(cell.text != NO_NUMBER for cell in line.cells))
            lines += [[*preset, *names_and_cells(line)] for line in told]
        texts = [*(["preset"] if several else []), *scores.contestants, "role"]
        heads = [*texts, *map(head, boards[0].columns)]
        return f"{markdown_table(heads, lines, words=len(texts))}\n\n{_origin(shown)}"

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
        return f"{markdown_table(heads, lines, words=len(heads))}\n\n{_varied(shown)}{_origin([shown])}"

    def figures(self, name: str) -> str:
        """See the module."""
        shown = self._read(name)
        lines = [
            [each["metric"].replace("_", " "), unit_sign(each["unit"]), _number(each)] for each in shown["summary"]
        ]
        return f"{markdown_table(['', 'unit', 'mean'], lines, words=2)}\n\n{_origin([shown])}"

    def value(self, name: str, contestant: str, metric: str) -> str:
        """See the module."""
        return _number(_entry(self._read(name), "summary", contestant, metric))

    def difference(self, name: str, contestant: str, other: str, metric: str) -> str:
        """See the module."""
        if not any(_is_of(each, contestant) for each in self._read(name)["comparisons"]):
            # Only comparisons of ours are kept.
            return self._paired((name, contestant), (name, other), metric)
        entry = _entry(self._read(name), "comparisons", contestant, metric, other)
        return _number({**entry, "mean": entry["difference"], "unit": suite(entry["suite"]).metric(metric).unit})

    def change(self, name: str, other: str, contestant: str, metric: str) -> str:
        """See the module."""
        return self._paired((name, contestant), (other, contestant), metric)

    def _paired(self, first: tuple[str, str], second: tuple[str, str], metric: str) -> str:
        """Return a contestant of a table minus another one, paired over the seeds that both have."""
        judged = suite(self._read(first[0])["summary"][0]["suite"]).metric(metric)
        mine, others = (
            [row for row in self._rows_of(name) if label(row) == contestant] for name, contestant in (first, second)
        )
        found = paired(mine, others, judged)
        if found is None:
            both = " and ".join(f"{contestant} in {name}" for name, contestant in (first, second))
            raise ValueError(f"difference: expected rows with {metric} on common seeds of {both}, got none")
        return _number(
            {"mean": found.difference, "ci_low": found.ci_low, "ci_high": found.ci_high, "unit": judged.unit}
        )

    def _rows_of(self, name: str) -> list[Row]:
        self._read(name)
        if name not in self._rows:
            self._rows[name] = [row for block in (read_rows_of(name) or {}).values() for row in block]
        return self._rows[name]


def check_one_run(shown: Sequence[TableFile]) -> None:
    """Raise ValueError for one table of several seeds, or with contestants that were tuned unequally."""
    names = ", ".join(each.name for each in shown)
    seeds = sorted({each["seeds"] for each in shown})
    check("table", len(seeds) == 1, f"one range of seeds in {names}", ", ".join(seeds))
    for kind in ("trackers", "controllers"):
        spent: dict[str, list[str]] = {}
        for each in shown:
            for name, budget in each["budgets"].get(kind, {}).items():
                spent.setdefault(", ".join(f"{key} {of}" for key, of in budget.items()), []).append(name)
        found = [f"{' '.join(sorted(set(of)))}: {budget}" for budget, of in spent.items()]
        check("table", len(found) <= 1, f"{kind} of {names} tuned with one budget", "; ".join(found))


def check_one_commit(shown: Iterable[TableFile]) -> None:
    """Raise ValueError for tables of a page, also of numbers in its prose, that were made at several commits."""
    made: dict[str, list[str]] = {}
    for each in shown:
        made.setdefault(each["commit"], []).append(each.name)
    found = [f"{commit} of {', '.join(sorted(names))}" for commit, names in sorted(made.items())]
    check("page", len(found) <= 1, "tables of one commit", "; ".join(found))


def _entry(shown: TableFile, key: str, contestant: str, metric: str, other: str | None = None) -> Mapping[str, Any]:
    found = [
        entry
        for entry in shown[key]
        if entry["metric"] == metric and _is_of(entry, contestant) and entry.get("other") == other
    ]
    wanted = f"one number of {contestant}{f' against {other}' if other else ''} in {metric}"
    check("value", len(found) == 1, f"{wanted} in {shown.name}", len(found))
    entry: Mapping[str, Any] = found[0]
    return entry


def _is_of(entry: Mapping[str, Any], contestant: str) -> bool:
    return contestant in (entry["tracker"], f"{entry.get('controller')}+{entry['tracker']}")


def _number(entry: Mapping[str, Any], *, sign: bool = False) -> str:
    unit = entry["unit"]
    text = " ".join(filter(None, (number_text(entry["mean"], unit), unit_sign(unit) if sign else "")))
    interval = interval_text(entry["ci_low"], entry["ci_high"], unit)
    return f"{text} ({short(interval)})" if interval else text


def _varied(shown: TableFile) -> str:
    """Return the table of what was fitted, varied, and the words on it; nothing where a paper's table has none."""
    varied = shown.contents.get("varied")
    if not varied:
        return ""
    return f"{varied['words']}\n\n{markdown_table(varied['heads'], varied['rows'], words=1)}\n\n"


def _origin(shown: Sequence[TableFile]) -> str:
    names = " ".join(each.name for each in shown)
    return f"Made by `frameout publish {names}` at commit {shown[0]['commit']}, seeds {shown[0]['seeds']}."
