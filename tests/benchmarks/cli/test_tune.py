from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from benchmarks.cli import tune as command
from benchmarks.cli.tune import Tune
from benchmarks.contract.rows import TEST_SPLIT
from benchmarks.contract.suite import controllers_suite, suites
from benchmarks.learning.tuning import (
    ControllerSearch,
    Search,
    TrackerSearch,
    Tuned,
    controllers_to_tune,
    trackers_to_tune,
)
from scenarios import catalog

pytest.importorskip("optuna")
_TUNED = Tuned({}, 1.0, 1.0, 1.0, 1.0, trials=40)


def _asked(monkeypatch: pytest.MonkeyPatch, tune: Tune) -> tuple[dict[str, TrackerSearch], dict[str, ControllerSearch]]:
    """Return the search of each tracker and, by its file, of each controller."""
    searches: list[Any] = []

    def tuned(search: Search, *_: Any) -> Tuned:
        searches.append(search)
        return _TUNED

    monkeypatch.setattr(command, "tune", tuned)
    assert tune.run() == 0
    trackers = {each.name: each for each in searches if isinstance(each, TrackerSearch)}
    return trackers, {each.place: each for each in searches if isinstance(each, ControllerSearch)}


def test_without_names_everything_is_tuned_and_rivals_have_the_same_number_of_trials(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    trackers, controllers = _asked(monkeypatch, Tune(out=tmp_path))
    assert tuple(trackers) == trackers_to_tune()
    assert {budget.suite for budget in trackers.values()} >= {"frame-out", "stereo", "fish", "harbour"}
    assert len(controllers) == sum(len(names) for _, names in controllers_to_tune()) >= 10
    assert {budget.trial_count for budget in trackers.values()} == {40}
    for budget in controllers.values():
        assert budget.trial_count == (40 if budget.scene.pictureless is None else 600)
    for name in ("colour_pf", "stereo_wb", "ca_kalman", "eigen_swarm", "mosaic_graph_pf"):
        assert (tmp_path / f"{name}.json").is_file()
    assert (tmp_path / "controllers" / "helicopter" / "reentry.json").is_file()


def test_all_of_a_suite_have_the_same_episodes_and_the_check_has_others(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    trackers, controllers = _asked(monkeypatch, Tune(out=tmp_path))
    for its_suite in suites().values():
        episodes = {
            (b.presets, b.seeds, b.fresh_presets, b.fresh) for b in trackers.values() if b.suite == its_suite.name
        }
        assert len(episodes) <= 1
    for budget in (*trackers.values(), *controllers.values()):
        assert budget.seeds.stop == budget.fresh.start
        assert budget.fresh.stop <= TEST_SPLIT.start


def test_names_presets_and_seeds_that_are_given_count(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    only = Tune(("hold",), trials=3, preset=("quick", "hard"), seeds=range(5, 7), fresh=1, out=tmp_path)
    trackers, controllers = _asked(monkeypatch, only)
    assert not controllers
    assert list(trackers) == ["hold"]
    budget = trackers["hold"]
    assert (budget.presets, budget.fresh_presets) == (("quick", "hard"), ("quick", "hard"))
    assert (budget.seeds, budget.fresh, budget.trials) == (range(5, 7), range(7, 8), 3)
    written = (tmp_path / "hold.json").read_text()
    assert '"frameout tune hold --trials 3 --preset quick hard --seeds 5:7 --fresh 1"' in written


def test_the_check_is_on_the_presets_that_the_suite_names_unless_others_are_given(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    trackers, _ = _asked(monkeypatch, Tune(("sort", "harbour_knn", "hold"), out=tmp_path))
    assert {name: each.fresh_presets for name, each in trackers.items()} == {
        "sort": ("standard", "hard"),
        "harbour_knn": ("standard",),
        "hold": ("standard",),
    }
    assert trackers["harbour_knn"].presets == ("ten-minutes",)
    assert (
        " --preset ten-minutes --seeds 300:304 --fresh 4 --fresh-preset standard"
        in (tmp_path / "harbour_knn.json").read_text()
    )
    trackers, _ = _asked(monkeypatch, Tune(("sort",), fresh_preset=("quick",), out=tmp_path))
    assert (trackers["sort"].presets, trackers["sort"].fresh_presets) == (("standard",), ("quick",))


def test_every_scene_names_presets_of_its_scenario() -> None:
    for its_suite in suites().values():
        for scene in its_suite.scenes if its_suite is controllers_suite() else its_suite.scenes[:1]:
            assert {scene.tuned_on.preset, *scene.tuned_on.fresh_presets} <= {*catalog.scenario(scene.scenario).presets}


def test_nothing_is_tuned_until_all_is_checked(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    searched: list[str] = []
    monkeypatch.setattr(command, "tune", lambda name, *_: searched.append(name))
    with pytest.raises(ValueError, match="preset: expected one for controllers, got"):
        Tune(preset=("quick", "standard"), out=tmp_path).run()
    with pytest.raises(ValueError, match=r"fresh_preset: expected one of .*; got 'hart'"):
        Tune(("hold",), fresh_preset=("hart",), out=tmp_path).run()
    with pytest.raises(ValueError, match=r"preset: expected one of .*; got 'quik'"):
        Tune(("hold",), preset=("quik",), out=tmp_path).run()
    with pytest.raises(ValueError, match="fresh_preset: expected none for controllers, got quick"):
        Tune(fresh_preset=("quick",), out=tmp_path).run()
    with pytest.raises(ValueError, match="tracker: expected none without --controllers, got 'colour_pf'"):
        Tune(tracker="colour_pf", out=tmp_path).run()
    with pytest.raises(ValueError, match="tracker: expected one with values of its own, got 'mosaic_graph_pf_no_ego'"):
        Tune(("hold", "mosaic_graph_pf_no_ego"), out=tmp_path).run()
    with pytest.raises(ValueError, match=r"tracker: expected one with a model of its errors .*, got 'hold'"):
        Tune(("hold",), ("centre",), tracker="hold", out=tmp_path).run()
    assert searched == []
