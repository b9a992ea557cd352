"""The page of definitions, made from the code.

Truth, metrics, columns of results and settings of presets; those of envs stand on ``envs_page``.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from benchmarks.contract import rows as records
from benchmarks.contract.metric import PooledRatios
from benchmarks.contract.suite import suites
from benchmarks.show.docstrings import attribute_meanings, place_of, words_of
from benchmarks.show.metric_definitions import definitions_of, metric_definitions
from benchmarks.show.preset_settings import preset_settings
from benchmarks.show.templates import page_environment
from benchmarks.statistics import summary
from benchmarks.statistics.bootstrap import Comparison, bootstrap_interval
from scenarios import catalog
from scenarios.envs.truth_info import truth_keys
from scenarios.truth import Truth, dtype_of, meanings
from trackers.papers import PAPERS


@dataclass(frozen=True, slots=True)
class TruthField:
    """A field of truth: dtype, shape and unit as in data sets and ``info``; meaning from the docstring."""

    name: str
    dtype: str
    shape: str
    unit: str
    meaning: str
    in_info: bool


def reference_page() -> str:
    """Return the page as Markdown."""
    environment = page_environment(__file__, autoescape=False)
    environment.filters |= {"cell": cell, "words": words_of, "place": place_of}
    return environment.get_template("reference.md.jinja").render(
        suites=suites().values(),
        metrics_of=metric_definitions,
        definitions_of=definitions_of,
        statistics=(PooledRatios, bootstrap_interval, Comparison),
        rows=records,
        columns={
            summary.SUMMARY_FILE_NAME: summary.SUMMARY_COLUMNS,
            summary.COMPARISONS_FILE_NAME: summary.COMPARISON_COLUMNS,
        },
        truth_words=words_of(Truth).partition("Attributes:")[0].strip(),
        fields=list(truth_fields(Truth)),
        scenarios=[catalog.scenario(name) for name in catalog.names()],
        own_truth=own_truth(),
        settings_of=preset_settings,
        papers=PAPERS.values(),
    )


def truth_fields(kind: type[Truth]) -> Iterator[TruthField]:
    """Yield the fields of a kind of truth, its bases' included."""
    cached: Any = kind
    words, in_info = attribute_meanings(kind), truth_keys(cached)
    for name, meaning in meanings(kind).items():
        shape = " × ".join(map(str, meaning.shape)) or "scalar"
        # Shape and dtype have columns of their own.
        text = re.sub(r"^\([^)]*\)( \w+\d+)?,? ?", "", words[name])
        codings = (part for part in meaning.coding.split("; ") if part not in text)
        told = "; ".join(filter(None, (text, *codings))) or " ".join(name.split("_")[:-1])
        yield TruthField(name, _dtype(kind, name, meaning.unit), shape, meaning.unit, told, name in in_info)


def own_truth() -> list[tuple[tuple[str, ...], list[TruthField]]]:
    """Return the fields that scenarios add to ``Truth``, with the ids of all that have them."""
    kinds: dict[type[Truth], list[str]] = {}
    for name in catalog.names():
        kinds.setdefault(catalog.scenario(name).truth, []).append(name)
    common = meanings(Truth)
    own = {tuple(ids): [each for each in truth_fields(kind) if each.name not in common] for kind, ids in kinds.items()}
    return [(ids, fields) for ids, fields in own.items() if fields]


def _dtype(kind: type[Truth], name: str, unit: str) -> str:
    """Return the dtype of a field; of words, and of objects of our own, which no dtype has, what they are."""
    if unit == "word":
        return "str"
    dtype = dtype_of(kind, name)
    return "object" if dtype.hasobject else dtype.name


def cell(text: Any) -> str:
    """Return text escaped for the cell of a table."""
    return str(text).replace("|", "\\|").replace("\n", " ")
