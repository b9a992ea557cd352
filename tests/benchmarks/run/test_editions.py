from __future__ import annotations

from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from benchmarks.contract.suite import register_suite, suite, suites
from benchmarks.contract.tracker_spec import TrackerSpec
from benchmarks.run import own_modules as imports
from benchmarks.run.editions import Editions, digest_of, judge_edition, own_code
from benchmarks.run.episodes import editions_of, simulated
from benchmarks.run.selection import tracker_named
from scenarios import catalog
from trackers.controllers import catalogue
from trackers.controllers.catalogue import controller_entry

ROW = ("frame-out", "road-town-v2", "quick")
TRACKER = '''"""A tracker."""
import math

GAIN = 2.0


def gain(value):
    """Return it."""
    return GAIN * value  # Twice.
'''


def made_of(tracker: TrackerSpec, *, judging: str = ROW[0], **how: Any) -> Editions:
    return editions_of(suite(judging), simulated(*ROW[1:], 0, **how), tracker)


def differing(first: dict[str, str], second: dict[str, str]) -> set[str]:
    """Return the parts of which two rows are of other editions."""
    return {name for name in first.keys() | second.keys() if first.get(name) != second.get(name)}


def test_a_row_names_scene_judge_tracker_and_packages() -> None:
    made = made_of(tracker_named("colour_pf"))
    assert set(made) == {"numpy", "numba", "opencv", "scene", "judge", "tracker"}
    assert made["scene"].startswith("road-town-v2 ")
    assert made["judge"] == f"frame-out {suite('frame-out').edition}"
    assert made["tracker"].startswith(f"colour_pf {tracker_named('colour_pf').edition} ")
    assert "pybullet" in made_of(tracker_named("colour_pf"), renderer="pybullet")


def test_a_change_of_a_parameter_or_an_edition_shows_and_only_there() -> None:
    known = tracker_named("colour_pf")
    before = made_of(known)
    other = replace(known, parameters=replace(known.parameters, particles=499))
    assert differing(before, made_of(other)) == {"tracker"}
    assert differing(before, made_of(replace(known, edition=known.edition + 1))) == {"tracker"}
    assert differing(before, made_of(known, changed={"frame_count": 90})) == {"scene"}


def test_a_change_of_a_preset_shows_and_only_there(monkeypatch: pytest.MonkeyPatch) -> None:
    before = made_of(tracker_named("colour_pf"))
    presets = catalog.scenario(ROW[1]).presets
    monkeypatch.setitem(presets, ROW[2], replace(presets[ROW[2]], frame_count=90))
    assert differing(before, made_of(tracker_named("colour_pf"))) == {"scene"}


def test_who_steers_shows_beside_what_tracks(monkeypatch: pytest.MonkeyPatch) -> None:
    known, centre = tracker_named("colour_pf"), controller_entry("centre", "helicopter")
    steered = made_of(known, controller="centre")
    assert differing(made_of(known), steered) == {"controller"}
    for other in (replace(centre, overrides={"fastest_mps": 1.0}), replace(centre, edition=2)):
        monkeypatch.setitem(catalogue._ENTRIES, ("helicopter", "centre"), other)
        assert differing(steered, made_of(known, controller="centre")) == {"controller"}


def test_a_new_suite_leaves_rows_of_others(monkeypatch: pytest.MonkeyPatch) -> None:
    before = made_of(tracker_named("colour_pf"))
    monkeypatch.setattr("benchmarks.contract.suite._SUITES", dict(suites()))
    register_suite(replace(suite("frame-out"), name="other", edition=3))
    assert made_of(tracker_named("colour_pf")) == before
    assert differing(before, made_of(tracker_named("colour_pf"), judging="other")) == {"judge"}


@dataclass(frozen=True)
class Lamp:
    watts: float = 60.0


@dataclass(frozen=True)
class Torch:
    watts: float = 60.0


@dataclass(frozen=True)
class Room:
    lamp: Lamp | Torch
    width_m: float = 3.0
    lamps: tuple[Lamp, ...] = field(default_factory=lambda: (Lamp(),))


@dataclass(frozen=True)
class WiderRoom:
    """``Room`` as it will be once it has another field."""

    lamp: Lamp | Torch
    width_m: float = 3.0
    lamps: tuple[Lamp, ...] = field(default_factory=lambda: (Lamp(),))
    places: NDArray[np.float64] = field(default_factory=lambda: np.zeros(2))


def test_a_digest_is_of_the_values_that_differ_from_defaults() -> None:
    plain = digest_of(Room(Lamp()))
    assert digest_of(Room(Lamp(60.0), 3.0)) == plain
    others = (
        Room(Torch()),
        Room(Lamp(40.0)),
        Room(Lamp(), 4.0),
        Room(Lamp(), lamps=()),
        Room(Lamp(), lamps=(Lamp(1),)),
    )
    assert len({plain, *map(digest_of, others)}) == 6
    WiderRoom.__name__ = "Room"
    assert digest_of(WiderRoom(Lamp())) == plain
    assert digest_of(WiderRoom(Lamp(), places=np.ones(2))) != plain


@pytest.fixture
def own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A user's tracker in a file, which imports another one of his."""
    monkeypatch.syspath_prepend(str(tmp_path))
    (tmp_path / "own_gain_model.py").write_text("WEIGHTS = 'weights.npz'\n")
    (tmp_path / "weights.npz").write_bytes(b"1")
    file = tmp_path / "own_gain_tracker.py"
    no_path = "a/" * 3000
    file.write_text(TRACKER + f"\n\nfrom own_gain_model import WEIGHTS\n\nTEXT = '{no_path}'\n")
    return file


def code_with(own: Path, file: str, text: str) -> str:
    """Return the digest of the user's module after a file beside it has got another text."""
    (own.parent / file).write_text(text)
    imports._imports.cache_clear()
    return own_code(own.stem)


def test_our_modules_have_no_digest() -> None:
    assert own_code(tracker_named("colour_pf").module) == ""
    assert own_code(type(catalog.scenario("road-town")).__module__) == ""
    assert judge_edition(suite("fish")) == f"fish {suite('fish').edition}"


def test_a_users_module_is_known_by_its_content_and_not_by_how_it_is_written(own: Path) -> None:
    before, text = own_code(own.stem), own.read_text()
    assert before
    for change in (
        ("  # Twice.", "  # Two times."),
        ("GAIN * value", "(GAIN\n        * value)"),
    ):
        assert text.count(change[0]) == 1
        assert code_with(own, own.name, text.replace(*change)) == before, change
    assert code_with(own, own.name, text.replace("2.0", "2.5")) != before


def test_what_a_users_module_imports_and_reads_is_part_of_it(own: Path) -> None:
    before = own_code(own.stem)
    assert code_with(own, "weights.npz", "2") != before
    assert code_with(own, "weights.npz", "1") == before
    assert code_with(own, "another.npz", "1") == before
    assert code_with(own, "own_gain_model.py", "WEIGHTS = 'weights.npz'\nMORE = 1\n") != before


def test_a_package_and_its_data_and_what_is_imported_by_name_are_part_of_a_module(own: Path) -> None:
    package = own.parent / "own_package"
    (package / "data").mkdir(parents=True)
    (package / "__init__.py").write_text("LIMIT = 1\n")
    (package / "part.py").write_text("FILE = 'data/net.bin'\n")
    (package / "data" / "net.bin").write_bytes(b"1")
    own.write_text(own.read_text() + "\nimport importlib\n\nimportlib.import_module('own_package.part')\n")
    before = own_code(own.stem)
    assert code_with(own, "own_package/__init__.py", "LIMIT = 2\n") != before
    assert code_with(own, "own_package/__init__.py", "LIMIT = 1\n") == before
    assert code_with(own, "own_package/data/net.bin", "2") != before
    assert code_with(own, "own_package/data/net.bin", "1") == before
    assert code_with(own, "own_package/part.py", "FILE = 'data/net.bin'\nMORE = 1\n") != before
