"""What a paper says, and what came out here: the same for experiments that run trackers and those that measure."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

from rich.console import Console
from rich.table import Table

from benchmarks.report.numbers import interval_text, number_text, ranges_text, unit_sign


@dataclass(frozen=True, slots=True)
class Claim:
    """What the paper says, and the number that it comes to here.

    Attributes:
        metric: of the rows or of the suite. counted: what the number is, in words. words: what the paper says.
        bound: which side of ``level`` agrees with the paper, by our choice; ``reported`` = the paper gives no side.
        tracker: the method it is about; "" where none runs.
        tolerance: how far off ``level`` still agrees, for the bound ``within``.
    """

    metric: str
    counted: str
    words: str = "not in the paper"
    bound: Literal["at most", "at least", "more than", "within", "reported"] = "reported"
    level: float = 0.0
    tracker: str = ""
    tolerance: float = 0.0


@dataclass(frozen=True, slots=True)
class Finding:
    """A claim and what came out, with one renderer.

    Attributes:
        mean, ci_low, ci_high: 95 % interval over episodes; None where nothing is known.
        unit: of the metric. episodes: that say something of it.
    """

    claim: Claim
    renderer: str
    mean: float | None
    ci_low: float | None
    ci_high: float | None
    unit: str
    episodes: int

    @property
    def agrees(self) -> bool | None:
        """Whether the mean lies on the paper's side; None where there is no side. Not known is no agreement."""
        if self.claim.bound == "reported":
            return None
        if self.mean is None:
            return False
        level = self.claim.level
        sides = {
            "at most": self.mean <= level,
            "at least": self.mean >= level,
            "more than": self.mean > level,
            "within": abs(self.mean - level) <= self.claim.tolerance,
        }
        return sides[self.claim.bound]

    @property
    def value(self) -> str:
        """The mean in words."""
        text = number_text(self.mean, self.unit)
        return text if self.mean is None else f"{text} {unit_sign(self.unit)}".rstrip()

    @property
    def interval(self) -> str:
        """The interval in words."""
        return interval_text(self.ci_low, self.ci_high, self.unit)

    @property
    def expected(self) -> str:
        """Bound and level in words."""
        if self.claim.bound == "reported":
            return "–"
        scale = 100.0 if self.unit == "fraction" else 1.0
        if self.claim.bound == "within":
            around = f"{scale * self.claim.level:g} ± {scale * self.claim.tolerance:g}"
            return f"{around} {unit_sign(self.unit)}".rstrip()
        return f"{self.claim.bound} {scale * self.claim.level:g} {unit_sign(self.unit)}".rstrip()


def print_findings(title: str, found: Sequence[Finding], seeds: range) -> None:
    """Print what came out beside the paper's words."""
    table = Table(title=f"{title}: seeds {ranges_text(seeds)}, 95 % intervals over them")
    methods = any(each.claim.tracker for each in found)
    for head in (*(["method"] if methods else []), "the paper", "here", "renderer", "value", "interval", "expected"):
        table.add_column(head)
    for each in found:
        claim = each.claim
        verdict = {True: ": yes", False: ": NO", None: ""}[each.agrees]
        named = [claim.tracker] if methods else []
        expected = f"{each.expected}{verdict}"
        table.add_row(*named, claim.words, claim.counted, each.renderer, each.value, each.interval, expected)
    console = Console()
    (console if console.is_terminal else Console(width=118)).print(table)
