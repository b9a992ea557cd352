"""Claims of a paper and our findings, for experiments with trackers and measurements."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, NamedTuple

from rich import box
from rich.table import Table

from benchmarks.contract.text import interval_text, number_text, ranges_text, unit_sign
from benchmarks.show.progress import console_of


@dataclass(frozen=True, slots=True)
class Claim:
    """A claim of the paper, and the number that tests it.

    Attributes:
        metric: of the rows or of the suite. counted: definition of the number, in words. words: the paper's claim.
        bound: the side of ``level`` that agrees with the paper, by our choice; ``interval below`` = all of the interval
            is below it; ``reported`` = the paper gives no side.
        tracker: name of the method; "" without one.
        preset: of the episodes; "" for the experiment's.
        tolerance: distance from ``level`` that still agrees, for the bound ``within``.
        minus: name of the method whose number on the same episodes is subtracted; "" without one.
        fitted: whether scene or method was set so that this number is the paper's: then it is no evidence for it.
    """

    metric: str
    counted: str
    words: str = "not in the paper"
    bound: Literal["at most", "at least", "more than", "within", "interval below", "reported"] = "reported"
    level: float = 0.0
    tracker: str = ""
    preset: str = ""
    tolerance: float = 0.0
    minus: str = ""
    fitted: bool = False


@dataclass(frozen=True, slots=True)
class Finding:
    """A claim and our value, with one renderer.

    Attributes:
        mean, ci_low, ci_high: 95 % interval over episodes; None without rows.
        unit: of the metric. episodes: number with rows of it.
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
        """Whether the mean lies on the paper's side; None where there is no side. An unknown mean does not agree."""
        if self.claim.bound == "reported":
            return None
        if self.mean is None or self.ci_high is None:
            return False
        level = self.claim.level
        sides = {
            "at most": self.mean <= level,
            "at least": self.mean >= level,
            "more than": self.mean > level,
            "interval below": self.ci_high < level,
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
            around = f"{scale * self.claim.level:.3g} ± {scale * self.claim.tolerance:.3g}"
            return f"{around} {unit_sign(self.unit)}".rstrip()
        return f"{self.claim.bound} {scale * self.claim.level:g} {unit_sign(self.unit)}".rstrip()


class Matrix(NamedTuple):
    """A table of numbers with a title and words about it; ``names`` head its rows and columns."""

    title: str
    words: str
    names: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]


def print_findings(title: str, found: Sequence[Finding], seeds: range, fitted: str = "") -> None:
    """Print our findings beside the paper's claims, those against a fitted figure marked, and what was fitted."""
    caption = f"fitted: {fitted}" if fitted else None
    several = len(seeds) > 1
    told = "seeds" if several else "seed"
    over = "95 % intervals over them" if several else "which decides nothing"
    renderers = {each.renderer for each in found}
    drawn = f", renderer {found[0].renderer}" if len(renderers) == 1 else ""
    heading = f"{title}: {told} {ranges_text(seeds)}, {over}{drawn}"
    heads = ("method", "the paper", "here", "renderer", "value", "interval", "expected")
    rows = []
    for each in found:
        claim = each.claim
        verdict = {True: ": yes", False: ": NO", None: ""}[each.agrees] if several else ""
        expected = f"{each.expected}{verdict}{' (fitted)' if claim.fitted else ''}"
        renderer = "" if drawn else each.renderer
        rows.append((claim.tracker, claim.words, claim.counted, renderer, each.value, each.interval, expected))
    print_table(heading, caption, heads, rows)


def print_matrix(matrix: Matrix) -> None:
    """Print a matrix under its title, with the words about it below."""
    rows = [(name, *row) for name, row in zip(matrix.names, matrix.rows, strict=True)]
    print_table(matrix.title, matrix.words, ("", *matrix.names), rows)


def print_table(title: str, words: str | None, heads: Sequence[str], rows: Sequence[Sequence[str]]) -> None:
    """Print a table of texts with words below it, without columns that have no text; columns of names stay whole."""
    table = Table(title=title, caption=words, caption_justify="left", box=box.SIMPLE_HEAD, padding=(0, 1, 0, 0))
    told = [texts for texts in zip(heads, *rows, strict=True) if any(texts[1:]) or not rows]
    for head, *texts in told:
        table.add_column(head, overflow="fold", no_wrap=not any(" " in text for text in texts))
    for row in zip(*(texts[1:] for texts in told), strict=True):
        table.add_row(*row)
    console_of().print(table)
