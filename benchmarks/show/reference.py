"""Pages of definitions, made from the code: one of truth, metrics, columns of results and presets, one of the envs."""

from __future__ import annotations

import inspect
import re
from collections.abc import Iterable, Iterator
from typing import Any, NamedTuple, get_type_hints

from jinja2 import Template

from benchmarks.contract import rows as records
from benchmarks.contract.metric import PooledRatios
from benchmarks.contract.suite import suites
from benchmarks.show.definitions import (
    attribute_meanings,
    definitions_of,
    grouped_by,
    metric_definitions,
    place_of,
    preset_settings,
    value_text,
    words_of,
)
from benchmarks.show.page import page_environment
from benchmarks.statistics import summary
from benchmarks.statistics.bootstrap import Comparison, bootstrap_interval
from scenarios import catalog
from scenarios.command_link import LINKS, Link
from scenarios.envs import observing
from scenarios.envs.follow_env import FollowEnv
from scenarios.envs.pictureless.vector_env import PicturelessVectorEnv
from scenarios.envs.reward import TERMS, Reward
from scenarios.envs.settings import RESET_OPTIONS, FollowSettings
from scenarios.envs.truth_info import INFO, truth_keys
from scenarios.envs.vectors import FollowVectorEnv
from scenarios.field_values import changeable, is_number
from scenarios.scenario import Scenario
from scenarios.truth import Truth, dtype_of, meanings
from trackers.belief import features
from trackers.controllers.catalogue import controllers
from trackers.papers import PAPERS
from trackers.types import CameraCommand

_UNITS = {"mps": "m/s", "rad_s": "rad/s", "per_s": "1/s"}


class TruthField(NamedTuple):
    """A field of truth: dtype, shape and unit as in data sets and ``info``; meaning from the docstring."""

    name: str
    dtype: str
    shape: str
    unit: str
    meaning: str
    in_info: bool


def reference_page() -> str:
    """Return the page as Markdown."""
    return _template("reference.md.jinja").render(
        suites=suites().values(),
        metrics_of=metric_definitions,
        definitions_of=definitions_of,
        statistics=(PooledRatios, bootstrap_interval, Comparison),
        judge_of=lambda suite: inspect.getmodule(suite.judge),
        rows=records,
        summary=summary,
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
        whole = "; ".join(filter(None, (text, *codings))) or " ".join(name.split("_")[:-1])
        yield TruthField(name, _dtype(kind, name, meaning.unit), shape, meaning.unit, whole, name in in_info)


def own_truth() -> list[tuple[list[str], list[TruthField]]]:
    """Return the fields that scenarios add to ``Truth``, with the ids of all that have them."""
    kinds, common = grouped_by(catalog.names(), lambda name: catalog.scenario(name).truth), meanings(Truth)
    own = [(ids, [each for each in truth_fields(kind) if each.name not in common]) for kind, ids in kinds.items()]
    return [(ids, fields) for ids, fields in own if fields]


def _dtype(kind: type[Truth], name: str, unit: str) -> str:
    """Return the dtype of a field; of words, and of objects of our own, which no dtype has, what they are."""
    if unit == "word":
        return "str"
    dtype = dtype_of(kind, name)
    return "object" if dtype.hasobject else dtype.name


def _template(name: str) -> Template:
    environment = page_environment(__file__, autoescape=False)
    environment.filters |= {"cell": _cell, "words": words_of, "place": place_of, "unit": _unit}
    return environment.get_template(name)


def _cell(text: Any) -> str:
    """Return text escaped for the cell of a table."""
    return str(text).replace("|", "\\|").replace("\n", " ")


class EnvRow(NamedTuple):
    """The catalogue entry of an env, its scenario, and the configuration of its default preset."""

    entry: catalog.Entry
    scenario: Scenario
    preset: Any


class Field(NamedTuple):
    """A field of a dataclass, as users set it: its type, a value, and meaning from the docstring.

    ``drawn``: whether ``randomise`` takes it.
    """

    name: str
    type: str
    value: str
    meaning: str
    drawn: bool


def envs_page() -> str:
    """Return the page as Markdown."""
    found = [(entry, catalog.scenario(entry.id)) for entry in catalog.entries() if entry.env_id]
    rows = [EnvRow(entry, scenario, scenario.presets[entry.preset]) for entry, scenario in found]
    ids = {row.entry.id for row in rows}
    keywords = fields_of(FollowSettings(rows[0].entry.id, rows[0].entry.tracker))
    kinds = grouped_by(rows, lambda row: type(row.preset)).values()
    by_carrier = grouped_by(rows, lambda row: row.scenario.carrier.name)
    return _template("envs.md.jinja").render(
        rows=rows,
        env=FollowEnv,
        vector_env=PicturelessVectorEnv,
        rendered_vector_env=FollowVectorEnv,
        keywords=[field for field in keywords if field.name != "scenario"],
        options=RESET_OPTIONS,
        configurations=[(alike, fields_of_preset(alike[-1].preset)) for alike in kinds],
        features=features,
        observing=observing,
        carriers=[(own[0].scenario.carrier, own, controllers(name)) for name, own in by_carrier.items()],
        command=CameraCommand,
        reward=Reward,
        reward_fields=fields_of(Reward()),
        terms=TERMS,
        links=LINKS,
        link=Link,
        info=INFO,
        own_truth=[(having, fields) for having, fields in own_truth() if ids & {*having}],
        timed_env=catalog.DEFAULT_ENV,
    )


def fields_of(settings: Any, names: Iterable[str] | None = None) -> list[Field]:
    """Return fields of a dataclass, all or some, with the values that it holds."""
    words, hints = attribute_meanings(type(settings)), get_type_hints(type(settings))
    values = {name: getattr(settings, name) for name in (words if names is None else names)}
    return [
        Field(name, _type_text(hints[name]), value_text(value), words[name], is_number(value))
        for name, value in values.items()
    ]


def fields_of_preset(preset: Any) -> list[Field]:
    """Return what ``changes`` takes of a preset, with the preset's values."""
    return fields_of(preset, changeable(preset))


def _unit(name: str) -> str:
    return next(unit for ending, unit in _UNITS.items() if name.endswith(ending))


def _type_text(kind: Any) -> str:
    """Return a type without the modules that define it."""
    text = kind.__name__ if isinstance(kind, type) and not hasattr(kind, "__args__") else str(kind)
    return re.sub(r"\b(?:\w+\.)+(?=\w)", "", text)
