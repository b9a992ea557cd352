"""Definitions made from the code: docstrings of things and of their fields, metrics in full, settings of presets."""

from __future__ import annotations

import dataclasses
import inspect
import re
from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple, TypeVar

from benchmarks.contract.metric import NOT_STATED, Metric
from benchmarks.contract.suite import Suite
from benchmarks.contract.text import range_text
from benchmarks.show.showing import showing_of

T = TypeVar("T")
K = TypeVar("K")

_ROOT = Path(__file__).resolve().parents[2]
_SECTION = re.compile(r"^(Args|Attributes|Raises|Returns|Yields):$", re.MULTILINE)


def words_of(thing: Any) -> str:
    """Return a docstring without its indentation, code in Markdown's marks."""
    return (inspect.getdoc(thing) or "").replace("``", "`")


def place_of(thing: Any) -> str:
    """Return the place of a definition, as ``benchmarks/judges/stereo/metrics/people.py: on_other``."""
    code = getattr(thing, "fget", thing)
    file = Path(inspect.getfile(code)).resolve()
    path = file.relative_to(_ROOT).as_posix() if file.is_relative_to(_ROOT) else file.name
    return path if inspect.ismodule(code) else f"{path}: {code.__qualname__}"


def attribute_meanings(kind: Any) -> dict[str, str]:
    """Return field -> its text in the docstrings of a dataclass or named tuple and its bases; "" for one without.

    Several may share a line, ``first: text. second: text.``, and a text, ``low, high: ends``, which then begins with
    their names.
    """
    names = [field.name for field in dataclasses.fields(kind)] if dataclasses.is_dataclass(kind) else list(kind._fields)
    meanings = dict.fromkeys(names, "")
    for each in reversed(kind.__mro__[:-1]):
        meanings |= _in_docstring(each, names)
    return meanings


def _in_docstring(kind: type, names: list[str]) -> dict[str, str]:
    _, _, section = (kind.__doc__ or "").partition("Attributes:")
    text = " ".join(_SECTION.split(inspect.cleandoc(section), maxsplit=1)[0].split()).replace("``", "`")
    name = "|".join(map(re.escape, sorted(names, key=len, reverse=True)))
    heads = list(re.finditer(rf"(?:^|(?<=[.;,)] ))((?:{name})(?:, (?:{name}))*): ", text))
    ends = [*(head.start() for head in heads[1:]), len(text)]
    meanings: dict[str, str] = {}
    for head, end in zip(heads, ends, strict=False):
        alike, words = head[1].split(", "), text[head.end() : end].strip(" ;,").removesuffix(".")
        shared = f"{', '.join(f'`{name}`' for name in alike)}: " if len(alike) > 1 else ""
        meanings |= dict.fromkeys(alike, f"{shared}{words}")
    return meanings


def metrics_of(suite: Suite) -> list[Metric]:
    """Return the metrics of a suite's summary, then those of only its events and facts."""
    found: dict[str, Metric] = {}
    facts = showing_of(suite).facts
    for metric in (*suite.metrics, *suite.events.compared, *(facts.columns if facts else ())):
        found.setdefault(metric.name, metric)
    return list(found.values())


def definitions_of(suite: Suite) -> dict[Any, dict[str, None]]:
    """Return the definitions of a suite's rows: function, class or module -> names of rows, as keys."""
    found: dict[Any, dict[str, None]] = defaultdict(dict)
    for metric in metrics_of(suite):
        own = () if metric.value is None else (metric.value,)
        for quantity in metric.statistic.of:
            for thing in (*own, *quantity.defined_by):
                found[thing][quantity.name] = None
    return found


def metric_definitions(suite: Suite, conditions: Mapping[str, str] = MappingProxyType({})) -> list[dict[str, Any]]:
    """Return the definitions of all metrics of a suite, see ``metrics_of``, each part in words.

    Beside those of ``Metric``: ``formula``: how rows make it; ``range`` of its values; ``better``: ``higher``,
    ``lower``, or the ideal value; ``conditions``: which frames, events or episodes count; ``source``: where the
    definitions of its rows come from; ``rows``: their names; ``defined_in``: places of their formulas.

    Args:
        conditions: of quantities, by name, in place of their own, see ``OnSequences``.
    """
    return [_definition(suite, metric, conditions) for metric in metrics_of(suite)]


def _definition(suite: Suite, metric: Metric, words: Mapping[str, str]) -> dict[str, Any]:
    statistic = metric.statistic
    named = [dataclasses.replace(each, conditions=words.get(each.name, each.conditions)) for each in statistic.of]
    stated = [each for each in named if each.conditions != NOT_STATED]
    conditions = dict.fromkeys(each.conditions for each in stated if each.conditions)
    of_kind = f"; of events: {statistic.kind}" if statistic.kind else ""
    in_seconds = metric.unit == "s" and "frames" in statistic.formula
    return {
        "suite": suite.name,
        "name": metric.name,
        "summary": metric.summary,
        "formula": statistic.words(),
        "range": range_text(*statistic.range()) + (" frames, in s" if in_seconds else ""),
        "unit": metric.unit,
        "better": metric.better if metric.ideal is None else f"{metric.ideal:g}",
        "conditions": "; ".join(conditions or [NOT_STATED]) + of_kind,
        "source": "; ".join(dict.fromkeys(each.source for each in stated)) or NOT_STATED,
        "rows": [each.name for each in statistic.of],
        "defined_in": [place_of(each) for each in metric.definitions],
    }


def grouped_by(items: Iterable[T], key: Callable[[T], K]) -> dict[K, list[T]]:
    """Return items by a key of theirs, in their order."""
    groups: dict[K, list[T]] = defaultdict(list)
    for each in items:
        groups[key(each)].append(each)
    return groups


class Setting(NamedTuple):
    """A setting of presets.

    Attributes:
        name: of the field, with those of the dataclasses that hold it, e.g. ``ego.heading_rad``.
        meaning: from the docstring.
        presets: text of a value -> the presets that have it, in their order.
    """

    name: str
    meaning: str
    presets: Mapping[str, list[str]]


def preset_settings(presets: Mapping[str, Any]) -> list[tuple[list[str], list[Setting]]]:
    """Return the settings of presets, those of one kind of dataclass together, each with the presets' names."""
    kinds = grouped_by(presets, lambda name: type(presets[name])).values()
    return [(names, list(_settings({name: presets[name] for name in names}))) for names in kinds]


def _settings(presets: Mapping[str, Any], prefix: str = "") -> Iterator[Setting]:
    """Yield the settings of dataclasses of one kind; those of a nested one follow its own."""
    for name, meaning in attribute_meanings(type(next(iter(presets.values())))).items():
        values = {preset: getattr(configuration, name) for preset, configuration in presets.items()}
        nested = {preset: value for preset, value in values.items() if _is_nested(value)}
        plain = {preset: value_text(value) for preset, value in values.items() if preset not in nested}
        yield Setting(prefix + name, meaning, grouped_by(plain, plain.__getitem__))
        if len({type(value) for value in nested.values()}) == 1:
            yield from _settings(nested, f"{prefix}{name}.")


def _is_nested(value: Any) -> bool:
    return dataclasses.is_dataclass(value) or hasattr(value, "_fields")


def value_text(value: Any) -> str:
    """Return a value as users write it in ``changes``."""
    if isinstance(value, float):
        return f"{value:g}"
    if isinstance(value, Sequence) and not isinstance(value, str):
        return f"({', '.join(map(value_text, value))}{',' if len(value) == 1 else ''})"
    return repr(value)
