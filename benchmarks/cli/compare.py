"""``frameout compare``: paired differences of two trackers, by kind of frame-out or other event."""

from __future__ import annotations

import json
import math
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Annotated, Any

import tyro
from rich import box
from rich.markup import escape
from rich.table import Table

from benchmarks.cli.arguments import ONE_NAME, Names, WithModules, report_ignored_rows
from benchmarks.contract.metric import Metric
from benchmarks.contract.rows import REAL, Row, read_rows
from benchmarks.contract.suite import DEFAULT, EventWords, suite
from benchmarks.contract.text import interval_text, number_text, time_in_words, unit_sign
from benchmarks.show.progress import console_of
from benchmarks.show.tables import NO_NUMBER
from benchmarks.statistics.bootstrap import Comparison
from benchmarks.statistics.summary import by_attribute, label_of
from sim.checks import check, check_choice
from trackers.controllers.catalogue import POLICY


@dataclass(frozen=True)
class Compare(WithModules):
    """Paired differences of two trackers with 95 % intervals: by kind, side, turn and length of the frame-out; in other
    suites by kind of event, e.g. after a lamp goes off, or over whole episodes.

    A tracker is named as in `frameout list`, or as FOLDER:NAME to take it from another result folder (the same tracker
    with two renderers, or before and after a change). In the suite follow the two are pairs, CONTROLLER+TRACKER. Only
    episodes that both have run are compared. p-values are corrected for the number of comparisons (Holm).

    Attributes:
        first: name of a tracker, or FOLDER:NAME; in the suite follow CONTROLLER+TRACKER.
        second: name of another; differences are first minus second.
        directory: result folder of names without one.
        suite: use rows of this suite only; needed where both have rows of several.
        preset: use rows of this preset only.
        metric: of those that the table shows, show these alone; p-values stay corrected for all.
        json: print JSON instead of a table.
    """

    first: Annotated[str, tyro.conf.Positional]
    second: Annotated[str, tyro.conf.Positional]
    directory: Path = Path("results") / DEFAULT
    suite: Annotated[str | None, ONE_NAME] = None
    preset: Annotated[str | None, ONE_NAME] = None
    metric: Names = ()
    json: bool = False
    resumes = False

    def run(self) -> int:
        """Print it; return the exit status."""
        for directory in dict.fromkeys(self._place_of(name)[0] for name in (self.first, self.second)):
            report_ignored_rows(directory, self.modules)
        first, second = (self._rows(name) for name in (self.first, self.second))
        judged = self._suite_of_both(first, second)
        first, second = ([row for row in rows if row["suite"] == judged] for rows in (first, second))
        self._check_alike(first, second)
        both = set(map(_episode_of, first)) & set(map(_episode_of, second))
        first, second = ([row for row in rows if _episode_of(row) in both] for rows in (first, second))
        found = by_attribute(first, second) if both else []
        check("second", bool(found), f"a tracker with episodes that {self.first} ran on", repr(self.second))
        for name in self.metric:
            check_choice("metric", name, dict.fromkeys(metric.name for _, metric, _, _ in found))
        found = [each for each in found if not self.metric or each[1].name in self.metric]
        words = suite(judged).events
        if self.json:
            print(json.dumps([_as_data(words, *each) for each in found], indent=1))
        else:
            console_of().print(self._table(words, found, _times_of(first), _times_of(second)))
        return 0

    def _suite_of_both(self, first: list[Row], second: list[Row]) -> str:
        """Return the suite to compare in. Raises ValueError for none in common, and for several with none named."""
        suites = sorted({row["suite"] for row in first} & {row["suite"] for row in second})
        check("second", bool(suites), f"a tracker of a suite that {self.first} has rows of", repr(self.second))
        if self.suite is None:
            check("suite", len(suites) == 1, f"one of {', '.join(suites)}, as both have rows of them", "none")
        chosen = self.suite or suites[0]
        check_choice("suite", chosen, suites)
        return chosen

    def _check_alike(self, first: list[Row], second: list[Row]) -> None:
        """Raise ValueError for controllers' rows of several scenarios or links, for simulated beside real ones, and for
        recordings of one name that differ.
        """
        rows = [*first, *second]
        kinds = {row["scenario"] == REAL for row in rows}
        check("preset", len(kinds) == 1, "one of rows that are all real or all simulated", repr(self.preset))
        scenes: dict[tuple[str, int], set[str]] = {}
        for row in rows if kinds == {True} else ():
            scenes.setdefault((row["preset"], row["seed"]), set()).add(row.get("editions", {}).get("scene", ""))
        other = sorted({preset for (preset, _), found in scenes.items() if len(found) > 1})
        check("directory", not other, "results on the same recordings", f"others called {', '.join(other)}")
        for key in ("scenario", "link") if suite(first[0]["suite"]).judges_controllers else ():
            values = sorted({row[key] for row in rows if key in row})
            check("directory", len(values) <= 1, f"results of one {key}", ", ".join(values))

    def _rows(self, name: str) -> list[Row]:
        directory, tracker = self._place_of(name)
        rows = read_rows(directory)
        check_choice(f"tracker in {directory}", tracker, sorted({label_of(row) for row in rows}))
        if self.preset is not None:
            check_choice(f"preset in {directory}", self.preset, sorted({row["preset"] for row in rows}))
        return [row for row in rows if label_of(row) == tracker and self.preset in (None, row["preset"])]

    def _place_of(self, name: str) -> tuple[Path, str]:
        """Return the folder and the tracker's name, which may contain a colon too (a policy's file)."""
        folder, colon, tracker = name.partition(":")
        return (Path(folder), tracker) if colon and not name.startswith(POLICY) else (self.directory, name)

    def _table(
        self, words: EventWords, found: list[tuple[str, Metric, Comparison, float]], first_time: str, second_time: str
    ) -> Table:
        title = f"{self.first}{first_time} minus {self.second}{second_time}, paired over episodes"
        table = Table(title=escape(title), box=box.SIMPLE_HEAD)
        for column in (words.name, "metric", "unit"):
            table.add_column(column, overflow="fold")
        for column in ("difference", "95 % interval", "p (Holm)", "episodes"):
            table.add_column(column, justify="right", no_wrap=column != "95 % interval")
        previous = None
        for attribute, metric, comparison, p_holm in found:
            low, high, unit = comparison.ci_low, comparison.ci_high, metric.unit
            table.add_row(
                attribute if attribute != previous else "",
                f"{metric.name} ({'↑' if metric.better == 'higher' else '↓'})",
                "points" if unit == "fraction" else unit_sign(unit),
                number_text(comparison.difference, unit, signed=True),
                interval_text(low, high, unit, signed=True) or NO_NUMBER,
                f"{p_holm:.4f}",
                str(comparison.n),
                style="bold" if low > 0 or high < 0 else "",
            )
            previous = attribute
        return table


def _episode_of(row: Row) -> tuple[str, str, int]:
    return row["scenario"], row["preset"], row["seed"]


def _times_of(rows: list[Row]) -> str:
    """Return how a tracker had time, in brackets; "" if it was not in real time."""
    rates_hz = sorted({row["real_time_hz"] for row in rows if "real_time_hz" in row})
    return f" ({', '.join(map(time_in_words, rates_hz))})" if rates_hz else ""


def _as_data(
    words: EventWords, attribute: str, metric: Metric, comparison: Comparison, p_holm: float
) -> dict[str, Any]:
    numbers = {name: value if math.isfinite(value) else None for name, value in asdict(comparison).items()}
    return {f"{words.key}s": attribute, "metric": metric.name, **numbers, "p_holm": p_holm}
