"""Ranges that a scene cannot keep are refused when a preset is made, in one line that names the field."""

from __future__ import annotations

from dataclasses import fields, is_dataclass, replace
from typing import Any

import pytest

from scenarios import catalog

SHIPPED = [entry.id for entry in catalog.entries() if entry.place.startswith("scenarios.")]
CONFIGURATIONS = [(name, preset) for name in SHIPPED for preset in catalog.scenario(name).presets.values()]


def _first_of_each_kind() -> list[Any]:
    return list({type(preset): preset for _, preset in reversed(CONFIGURATIONS)}.values())


def _numbers(preset: Any) -> list[str]:
    return [f.name for f in fields(preset) if type(getattr(preset, f.name)) in (int, float)]


def _ranges(preset: Any) -> list[str]:
    values = {f.name: getattr(preset, f.name) for f in fields(preset)}
    return [n for n, v in values.items() if isinstance(v, tuple) and len(v) == 2 and type(v[0]) in (int, float)]


@pytest.mark.parametrize("preset", _first_of_each_kind(), ids=lambda preset: type(preset).__name__)
def test_each_number_of_a_preset_has_a_lowest_and_a_highest_value(preset: Any) -> None:
    assert is_dataclass(preset)
    for name in _numbers(preset):
        for value in (-1, 10**9, float("nan"), float("inf")):
            with pytest.raises(ValueError, match=rf"^{name}: expected .*, got [^\n]*$"):
                replace(preset, **{name: value})
    for name in _ranges(preset):
        low, high = getattr(preset, name)
        reversed_range = (high, low) if high > low else (high + 1, low)
        for value in ((-1, high), (low, 10**9), reversed_range, (low, float("nan"))):
            with pytest.raises(ValueError, match=rf"^{name}: expected .*, got [^\n]*$"):
                replace(preset, **{name: type(getattr(preset, name))(value)})


@pytest.mark.parametrize(("name", "preset"), CONFIGURATIONS, ids=lambda given: str(given)[:24])
def test_an_episode_of_any_scene_has_two_frames_or_more(name: str, preset: Any) -> None:
    if "frame_count" not in {f.name for f in fields(preset)}:
        return
    for count in (-1, 0, 1, 10**6):
        with pytest.raises(
            ValueError, match=r"^frame_count: expected (at least \d+|a whole number in \[2, \d+\]).*, got"
        ):
            replace(preset, frame_count=count)
    for rate_hz in (0.0, 1e-6, 1e6):
        with pytest.raises(ValueError, match=r"^rate_hz: expected a number in \[0.\d+, 1000\], got"):
            replace(preset, rate_hz=rate_hz)
