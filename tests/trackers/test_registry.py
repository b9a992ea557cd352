"""The registry: names, roles, parameters, variants, and trackers of many targets that are asked to follow one."""

from __future__ import annotations

import importlib
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from trackers import registry
from trackers.controllers import catalogue
from trackers.follow_one import FollowOne
from trackers.registry import NoParameters, entry, register, register_variant, tunable, tuned_file
from trackers.types import CameraModel, Observation, Track


@dataclass(frozen=True)
class _Parameters:
    gate_px: float = tunable(8.0, 2.0, 30.0)
    least_px: int = 4


class _Many:
    Parameters = _Parameters

    def __init__(self, parameters: _Parameters, rng: np.random.Generator) -> None:
        self.parameters = parameters

    def start(self, background: Sequence[Observation], camera: CameraModel) -> None:
        """See ``MultiTracker``."""

    def update(self, observation: Observation) -> Sequence[Track]:
        """See ``MultiTracker``."""
        return ()


@pytest.fixture(autouse=True)
def _as_before(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(registry, "_ENTRIES", registry.entries())


def test_the_tables_name_what_each_module_registers() -> None:
    ours = {name: each for name, each in registry.entries().items() if each.tracker.__module__.startswith("trackers.")}
    assert {name: registry._home(name) for name in ours} == {
        name: each.tracker.__module__ for name, each in ours.items()
    }
    assert [name for name, each in ours.items() if name in registry._HOMES] == list(registry._HOMES)
    for carrier, modules in catalogue._MODULES.items():
        steering = catalogue.controllers(carrier)
        homes = {name: f"trackers.controllers.{module}" for name, module in modules.items()}
        assert {name: steering[name].controller.__module__ for name in homes} == homes
        own = [
            name.removesuffix("_as_written")
            for name in steering
            if steering[name].controller.__module__ in homes.values()
        ]
        assert list(dict.fromkeys(own)) == list(modules)


@pytest.mark.parametrize(
    ("looked_up", "home"),
    [
        ("registry.entry('hold')", registry._HOMES["hold"]),
        ("registry.entry('colour_pf_tuned')", registry._HOMES["colour_pf"]),
        ("catalogue.controller_entry('hold', 'robot')", "trackers.controllers.hold"),
        ("papers.paper_of('trackers.road_shape.colour_pf')", None),
    ],
)
def test_a_name_that_is_looked_up_imports_one_method(looked_up: str, home: str | None) -> None:
    script = f"""
import sys
from trackers import papers, registry
from trackers.controllers import catalogue
{looked_up}
print(*sys.modules)
"""
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    steering = {f"trackers.controllers.{name}" for names in catalogue._MODULES.values() for name in names.values()}
    assert {*registry._MODULES, *steering}.intersection(done.stdout.split()) == ({home} if home else set())


def test_a_tracker_of_many_targets_follows_one_where_one_is_asked_for() -> None:
    register("many", role="ours", summary="many targets")(_Many)
    rng = np.random.default_rng(0)
    assert entry("many").follows_many
    assert isinstance(entry("many").create(rng), _Many)
    assert isinstance(entry("many").create_for_one(rng), FollowOne)


def test_a_tracker_of_one_target_is_handed_out_as_it_is() -> None:
    hold = entry("hold")
    assert not hold.follows_many
    assert type(hold.create_for_one(np.random.default_rng(0))) is type(hold.create(np.random.default_rng(0)))


def test_a_variant_has_its_overrides_and_is_written_with_them() -> None:
    register("many", role="ours", summary="many targets")(_Many)
    register_variant("many_wide", "many", summary="a wide gate", gate_px=20.0)
    assert entry("many_wide").role == "variant"
    assert entry("many_wide").parameters() == _Parameters(gate_px=20.0)
    assert entry("many_wide").parameters(least_px=9) == _Parameters(gate_px=20.0, least_px=9)
    assert entry("many_wide").written() == {"gate_px": 20.0}
    assert entry("many").written() == {"gate_px": 8.0}


def test_a_paper_s_method_stays_as_written_and_stands_again_tuned(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(registry, "tuned_values", lambda name, module: {"gate_px": 33.0} if name == "many" else {})
    register("many", role="as-written", summary="many targets")(_Many)
    assert entry("many").parameters().gate_px == entry("many").written()["gate_px"] == 8.0
    assert entry("many_tuned").role == "tuned"
    assert entry("many_tuned").parameters().gate_px == 33.0
    register_variant("many_wide", "many", summary="another least size", least_px=9)
    assert entry("many_wide").parameters() == _Parameters(least_px=9)


def test_a_paper_s_method_without_better_values_stands_once(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(registry, "tuned_values", lambda name, module: {})
    register("many", role="as-written", summary="many targets")(_Many)
    assert "many_tuned" not in registry.entries()


@pytest.mark.parametrize("content", ["{", "{}", "[]", '{"parameters": 3}'])
def test_a_file_of_tuned_values_that_holds_none_is_named(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, content: str
) -> None:
    (tmp_path / "mine.json").write_text(content)
    monkeypatch.setattr(registry, "tuned_file", lambda name, module: tmp_path / "mine.json")
    with pytest.raises(ValueError, match=r"mine\.json: expected JSON such as"):
        registry.tuned_values("mine", "mine")


def test_tuned_values_replace_the_defaults_of_others(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(registry, "tuned_values", lambda name, module: {"gate_px": 33.0})
    register("many", role="baseline", summary="many targets")(_Many)
    assert entry("many").parameters().gate_px == 33.0
    assert "many_tuned" not in registry.entries()


@pytest.mark.parametrize(
    ("default", "low", "high", "log"),
    [(2, 9, 1, False), (5.0, 0.0, 1.0, False), (1, 1, 1, False), (0.5, 0.0, 1.0, True)],
)
def test_bounds_that_tuning_cannot_search_are_refused(default: float, low: float, high: float, log: bool) -> None:
    told = f"tunable: expected low < high with the default between them.*, got default {default}, low {low} and high"
    with pytest.raises(ValueError, match=told):
        tunable(default, low, high, log=log)


def test_what_cannot_be_registered_is_refused_by_name() -> None:
    with pytest.raises(ValueError, match="name: expected one that no tracker has, got 'hold'"):
        register("hold", role="ours", summary="")(_Many)
    with pytest.raises(ValueError, match=r"role: expected one of .*; got 'best'"):
        register("many", role="best", summary="")(_Many)  # type: ignore[arg-type]
    for method in ("start", "update"):
        broken = type("Broken", (_Many,), {method: None})
        with pytest.raises(ValueError, match=f"{method}: expected a method of this name in class Broken, got none"):
            register("many", role="baseline", summary="")(broken)
    nameless = type("Begins", (), {"Parameters": NoParameters, "update": _Many.update})
    with pytest.raises(ValueError, match=r"tracker: expected a method initialise, or start if .* Begins, got neither"):
        register("many", role="baseline", summary="")(nameless)
    with pytest.raises(ValueError, match="Parameters: expected a dataclass of this name in class object, got none"):
        register("many", role="ours", summary="")(object)
    assert "many" not in registry.entries()


def test_a_variant_takes_no_name_of_ours() -> None:
    for name in ("hold", "mosaic_graph_pf"):
        with pytest.raises(ValueError, match=f"name: expected one that no tracker has, got {name!r}"):
            register_variant(name, "mosaic_graph_pf", summary="mine", use_roads=False)
    with pytest.raises(ValueError, match=r"tracker: expected one of .*; got 'nobody'"):
        register_variant("mine", "nobody", summary="mine")


@pytest.mark.heavy
def test_a_user_s_module_that_comes_first_takes_no_name_of_ours(tmp_path: Path) -> None:
    (tmp_path / "first.py").write_text(
        "from trackers.registry import NoParameters, register\n"
        "from trackers.controllers.catalogue import register_controller\n"
        "class Mine:\n"
        "    Parameters = NoParameters\n"
        "    initialise = update = command = print\n"
        "for add, taken in ((register, {}), (register_controller, {'carrier': 'robot'})):\n"
        "    try:\n"
        "        add('hold', role='baseline', summary='', **taken)(Mine)\n"
        "    except ValueError as error:\n"
        "        print(error)\n"
    )
    done = subprocess.run([sys.executable, tmp_path / "first.py"], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines() == [
        "name: expected one that no tracker has, got 'hold'",
        "name: expected one that no controller of a robot has, got 'hold'",
    ]


def test_values_of_a_user_s_tracker_lie_beside_its_module(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "own_tracker_of_a_user.py").write_text(
        "from tests.trackers.test_registry import _Many\n\nclass Own(_Many):\n    pass\n"
    )
    (tmp_path / "tuned").mkdir()
    (tmp_path / "tuned" / "own_many.json").write_text('{"parameters": {"gate_px": 44.0}}')
    monkeypatch.syspath_prepend(tmp_path)
    module = importlib.import_module("own_tracker_of_a_user")
    register("own_many", role="external", summary="")(module.Own)
    assert entry("own_many").parameters().gate_px == 44.0
    assert tuned_file("hold", entry("hold").tracker.__module__).parent == Path(registry.__file__).parent / "tuned"


def test_a_method_of_which_the_file_says_why_it_is_kept_as_written_stands_with_both_values(tmp_path: Path) -> None:
    (tmp_path / "tuned").mkdir()
    said = '{"parameters": {"gate_px": 44.0}, "kept_as_written": "worse in other weather"}'
    (tmp_path / "tuned" / "own_kept.json").write_text(said)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(sys.modules[_Many.__module__], "__file__", str(tmp_path / "own.py"))
        register("own_kept", role="baseline", summary="")(_Many)
        assert entry("own_kept").parameters().gate_px == entry("own_kept").written()["gate_px"] == 8.0
        assert entry("own_kept_tuned").role == "tuned"
        assert entry("own_kept_tuned").parameters().gate_px == 44.0


def test_an_unknown_name_and_an_unknown_parameter_are_named() -> None:
    with pytest.raises(ValueError, match=r"tracker: expected one of .*hold, .*; got 'hodl'"):
        entry("hodl")
    with pytest.raises(ValueError, match=r"hold: expected parameters among .*, got 'gate_px\'"):
        entry("hold").parameters(gate_px=3.0)
