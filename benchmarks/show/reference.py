"""Pages of definitions, made from the code: one of truth, metrics, columns of results and presets, one of the envs."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any, get_type_hints

from jinja2 import Template

from benchmarks.contract import rows as records
from benchmarks.contract.metric import PooledRatios
from benchmarks.contract.suite import suites
from benchmarks.show.definitions import (
    attribute_meanings,
    definitions_of,
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
from scenarios.envs.follow_env import FollowEnv
from scenarios.envs.pictureless.vector_env import PicturelessVectorEnv
from scenarios.envs.reward import TERMS, Reward
from scenarios.envs.settings import RESET_OPTIONS, FollowSettings, changeable, is_number
from scenarios.envs.truth_info import INFO, truth_keys
from scenarios.scenario import Scenario
from scenarios.truth import Truth, dtype_of, meanings
from trackers.belief import features
from trackers.controllers.catalogue import ControllerEntry, controllers
from trackers.papers import PAPERS
from trackers.types import CameraCommand, Carrier

_UNITS = {"mps": "m/s", "rad_s": "rad/s", "per_s": "1/s"}


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
    return _template("reference.md.jinja").render(
        suites=suites().values(),
        metrics_of=metric_definitions,
        definitions_of=definitions_of,
        statistics=(PooledRatios, bootstrap_interval, Comparison),
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


def _template(name: str) -> Template:
    environment = page_environment(__file__, autoescape=False)
    environment.filters |= {"cell": _cell, "words": words_of, "place": place_of, "unit": _unit}
    return environment.get_template(name)


def _cell(text: Any) -> str:
    """Return text escaped for the cell of a table."""
    return str(text).replace("|", "\\|").replace("\n", " ")


@dataclass(frozen=True, slots=True)
class EnvRow:
    """An env id, its catalogue entry and its scenario."""

    entry: catalog.Entry
    scenario: Scenario

    @property
    def preset(self) -> Any:
        """The configuration of its default preset."""
        return self.scenario.presets[self.entry.preset]


@dataclass(frozen=True, slots=True)
class Field:
    """A field of a dataclass, as users set it: its type, default, and meaning from the docstring.

    ``drawn``: whether ``randomise`` takes it.
    """

    name: str
    type: str
    default: str
    meaning: str
    drawn: bool


def envs_page() -> str:
    """Return the page as Markdown."""
    rows = [EnvRow(entry, catalog.scenario(entry.id)) for entry in catalog.entries() if entry.env_id]
    return _template("envs.md.jinja").render(
        rows=rows,
        env=FollowEnv,
        vector_env=PicturelessVectorEnv,
        keywords=fields_of(FollowSettings, ["tracker"]),
        options=RESET_OPTIONS,
        configurations=_configurations(rows),
        features=features,
        carriers=_carriers(rows),
        command=CameraCommand,
        reward=Reward,
        reward_fields=fields_of(Reward),
        terms=TERMS,
        links=LINKS,
        link=Link,
        info=INFO,
        own_truth=[(ids, fields) for ids, fields in own_truth() if {row.entry.id for row in rows} & set(ids)],
        timed_env=catalog.DEFAULT_ENV,
    )


def fields_of(kind: Any, required: list[str] | None = None) -> list[Field]:
    """Return the fields with defaults of a kind of settings, and ``required`` ones."""
    meanings, hints, fields = attribute_meanings(kind), get_type_hints(kind), []
    for each in dataclasses.fields(kind):
        if each.default is not dataclasses.MISSING:
            default = value_text(each.default)
        elif each.default_factory is not dataclasses.MISSING:
            default = value_text(each.default_factory())
        elif each.name in (required or []):
            default = "of the env"
        else:
            continue
        fields.append(Field(each.name, _type_text(hints[each.name]), default, meanings[each.name], False))
    return fields


def fields_of_preset(preset: Any) -> list[Field]:
    """Return what ``changes`` takes of a preset, with the preset's values."""
    meanings, hints = attribute_meanings(type(preset)), get_type_hints(type(preset))
    return [
        Field(name, _type_text(hints[name]), value_text(value), meanings[name], is_number(value))
        for name, value in ((name, getattr(preset, name)) for name in changeable(preset))
    ]


def _configurations(rows: list[EnvRow]) -> list[tuple[list[EnvRow], list[Field]]]:
    """Return the fields of each kind of preset, with the values of the last env that has it, and all such envs."""
    kinds: dict[type, list[EnvRow]] = {}
    for row in rows:
        kinds.setdefault(type(row.preset), []).append(row)
    return [(mine, fields_of_preset(mine[-1].preset)) for mine in kinds.values()]


def _carriers(rows: list[EnvRow]) -> list[tuple[Carrier, list[str], Mapping[str, ControllerEntry]]]:
    """Return the carriers, each with its env ids and controllers."""
    ids: dict[str, list[str]] = {}
    carriers = {}
    for row in rows:
        carrier = row.scenario.carrier
        ids.setdefault(carrier.name, []).append(row.entry.env_id)
        carriers[carrier.name] = carrier
    return [(carriers[name], mine, controllers(name)) for name, mine in ids.items()]


def _unit(name: str) -> str:
    return next(unit for ending, unit in _UNITS.items() if name.endswith(ending))


def _type_text(kind: Any) -> str:
    """Return a type without the modules that define it."""
    text = kind.__name__ if isinstance(kind, type) and not hasattr(kind, "__args__") else str(kind)
    return re.sub(r"\b(?:\w+\.)+(?=\w)", "", text)
