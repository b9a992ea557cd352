"""The trackers of each scenario of the suite ``follow``; trackers with other values of a parameter."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from benchmarks.cli.main import main
from benchmarks.judges.follow.suite import FOLLOW
from benchmarks.judges.frame_out.suite import FRAME_OUT
from benchmarks.judges.stereo.suite import STEREO
from benchmarks.run.editions import tracker_edition
from benchmarks.run.selection import choices, experiment_on, tracker_named, trackers_of, varied_names
from scenarios import catalog
from scenarios.road_town.scenario import ROAD_TOWN
from trackers import registry
from trackers.controllers.catalogue import controllers

STANDARD = ("standard",)


def test_if_nobody_is_named_ours_and_another_watch_and_everybody_steers() -> None:
    chosen = choices(FOLLOW, presets=STANDARD, variants=True)
    roles = {choice.scenario: [each.role for each in choice.trackers.values()] for choice in chosen}
    of_papers = ("road-town-v2", "stereo-follow-v2", "fish-tank-v1", "harbour-v1")
    steered = ("fish-tank-ptz-v1", "harbour-ptz-v1")
    assert roles == {name: ["ours", "as-written"] for name in of_papers} | {name: ["baseline"] * 2 for name in steered}
    for choice in chosen:
        known = controllers(catalog.scenario(choice.scenario).carrier.name).values()
        assert choice.controllers == tuple(each.name for each in known)


def test_values_go_to_the_default_preset_of_each_scene() -> None:
    chosen = {each.scenario: each.presets for each in choices(FOLLOW, settings=("rate_hz=9",), variants=False)}
    assert chosen["road-town-v2"] == ("standard[rate_hz=9]",)
    assert chosen["harbour-v1"] == ("patrol[rate_hz=9]",)


def test_names_go_where_they_are_known() -> None:
    town, rooms, *heads = choices(
        FOLLOW,
        presets=STANDARD,
        trackers=("colour_pf", "stereo_wb", "opencv_mil"),
        controllers=("hold", "centre"),
        variants=True,
    )
    assert tuple(town.trackers) == ("colour_pf", "opencv_mil")
    assert tuple(rooms.trackers) == ("stereo_wb", "opencv_mil")
    assert [tuple(each.trackers) for each in heads] == [("colour_pf", "opencv_mil")] * 2
    assert {each.controllers for each in (town, rooms, *heads)} == {("hold", "centre")}
    (only,) = choices(FOLLOW, presets=STANDARD, trackers=("stereo_wb",), variants=True)
    assert only.scenario == "stereo-follow-v2"
    (only,) = choices(FOLLOW, scenarios=("stereo-follow",), presets=STANDARD, controllers=("hold",), variants=True)
    assert (only.scenario, only.controllers) == ("stereo-follow-v2", ("hold",))


NEXT_TOWN = replace(ROAD_TOWN, id="road-town-v3")


def test_an_earlier_version_takes_part_if_it_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(catalog, "_ENTRIES", (*catalog.entries(), catalog.Entry(NEXT_TOWN.id, f"{__name__}:NEXT_TOWN")))
    (town, *_) = choices(FOLLOW, presets=STANDARD, variants=True)
    assert town.scenario == "road-town-v3"
    (town,) = choices(FOLLOW, scenarios=("road-town-v2",), presets=STANDARD, variants=True)
    assert town.scenario == "road-town-v2"
    assert tuple(town.trackers) == FOLLOW.scene("road-town").trackers


def test_the_suites_own_reference_takes_part_if_it_is_named() -> None:
    (_, rooms, *_) = choices(
        FOLLOW, presets=STANDARD, trackers=("oracle_target",), controllers=("hold",), variants=True
    )
    assert (rooms.scenario, *rooms.trackers) == ("stereo-follow-v2", "oracle_target")
    (town,) = choices(FRAME_OUT, presets=STANDARD, variants=True)
    assert "oracle_target" not in town.trackers


def test_presets_go_where_they_are_known() -> None:
    def chosen(*presets: str) -> list[tuple[str, tuple[str, ...]]]:
        return [(p.scenario, p.presets) for p in choices(STEREO, presets=presets, variants=True)]

    people, sheets = "stereo-follow-v2", "paper-sheet-v1"
    assert chosen("standard") == [(people, ("standard",))]
    assert chosen("paper-b2") == [(sheets, ("paper-b2",))]
    assert chosen("quick", "paper-b1", "hard") == [(people, ("quick", "hard")), (sheets, ("paper-b1",))]
    # What no scenario has is refused by the first one's.
    assert chosen("nix", "paper-b1") == [(people, ("nix",)), (sheets, ("paper-b1",))]


def test_without_presets_each_scenario_has_its_default() -> None:
    presets = {choice.scenario: choice.presets for choice in choices(FOLLOW, variants=True)}
    assert presets["road-town-v2"] == presets["fish-tank-v1"] == ("standard",)
    assert presets["harbour-v1"] == ("patrol",)


def test_what_nobody_knows_is_refused() -> None:
    with pytest.raises(ValueError, match=r"trackers: expected one of .*mosaic_graph_pf.*; got 'nix'"):
        choices(FOLLOW, presets=STANDARD, trackers=("nix",), variants=True)
    with pytest.raises(ValueError, match=r"scenario: expected one of road-town, .*road-town-v2.*; got 'fish-v1'"):
        choices(FOLLOW, scenarios=("fish-v1",), presets=STANDARD, variants=True)


def test_a_suite_of_trackers_is_as_it_was() -> None:
    (choice,) = choices(FRAME_OUT, presets=STANDARD, controllers=("set-path",), variants=False)
    assert choice.controllers == ("set-path",)
    present = {name: each for name, each in trackers_of("frame-out").items() if not each.missing()}
    assert set(choice.trackers) == {name for name, each in present.items() if each.role != "variant"}
    assert choices(FRAME_OUT, presets=STANDARD, variants=True)[0].controllers == ()


def test_a_suite_made_of_another_has_trackers_of_its_own() -> None:
    """As in CONTRIBUTING: a new name, without trackers yet."""
    (choice,) = choices(replace(FRAME_OUT, name="while-seen"), presets=STANDARD, variants=True)
    assert choice.trackers == {}


def test_a_tracker_that_a_user_adds_runs_where_it_is_entered() -> None:
    mine = {"mine": replace(tracker_named("colour_pf"), name="mine", suites=("frame-out",))}
    (town,) = choices(FRAME_OUT, presets=STANDARD, added=mine, variants=False)
    assert town.trackers["mine"] is mine["mine"]
    assert "colour_pf" in town.trackers
    (only,) = choices(FRAME_OUT, presets=STANDARD, trackers=("mine",), added=mine, variants=False)
    assert only.trackers == mine
    (people,) = choices(STEREO, presets=STANDARD, added=mine, variants=False)
    assert "mine" not in people.trackers
    with pytest.raises(ValueError, match=r"got 'mine', which is of suite frame-out"):
        choices(STEREO, presets=STANDARD, trackers=("mine",), added=mine, variants=False)


def test_a_tracker_that_names_no_suite_is_of_the_default_one() -> None:
    unnamed = [name for name, entry in registry.entries().items() if not entry.suites]
    assert "colour_pf" in unnamed
    assert {trackers_of()[name].suites for name in unnamed} == {("frame-out",)}


def test_other_suites_know_no_link(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["bench", "stereo", "--link", "noisy", "--out", str(tmp_path)]) == 2
    assert "link: expected prompt, since suite stereo knows no other, got 'noisy'" in capsys.readouterr().err


def test_a_value_of_a_parameter_makes_a_tracker_of_its_own() -> None:
    names = varied_names(["colour_pf.particles=50,200", "road_shape_pf.particles=70"])
    assert names == ("colour_pf[particles=50]", "colour_pf[particles=200]", "road_shape_pf[particles=70]")
    made = tracker_named(names[0])
    assert made.parameters == replace(tracker_named("colour_pf").parameters, particles=50)
    # The same random numbers as without the value.
    assert made.name == "colour_pf"
    assert tracker_edition(made) != tracker_edition(tracker_named("colour_pf"))
    usual = tracker_named("colour_pf").parameters.particles
    assert tracker_edition(tracker_named(f"colour_pf[particles={usual}]")) == tracker_edition(
        tracker_named("colour_pf")
    )
    experiment = experiment_on("frame-out", "road-town", ["quick"], names, range(2))
    assert [each.parameters.particles for each in experiment.trackers.values()] == [50, 200, 70]
    (choice,) = choices(FRAME_OUT, trackers=names, variants=False)
    assert tuple(choice.trackers) == names


@pytest.mark.parametrize(
    ("word", "message"),
    [
        ("colour_pf", r"vary: expected NAME.PARAMETER=V1,V2,…, such as colour_pf.particles=50,200, got 'colour_pf'"),
        ("colour_pf.particles=", "vary: expected"),
        ("colour_pf.particles=50,", "vary: expected"),
        ("colour_pf.particles=many", "colour_pf.particles: expected a whole number, got 'many'"),
        ("colour_pf.particles=2.5", "colour_pf.particles: expected a whole number, got '2.5'"),
        ("colour_pf.grains=5", "colour_pf: expected parameters among .*, got 'grains'"),
        ("nobody.particles=5", "tracker: expected one of .*; got 'nobody'"),
        ("oracle_map.particles=5", "tracker: expected one of .*; got 'oracle_map'"),
    ],
)
def test_what_is_no_value_of_a_parameter_is_named(word: str, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        varied_names([word])


def test_a_tracker_of_another_suite_stays_one_whatever_its_values() -> None:
    with pytest.raises(ValueError, match="trackers: expected one of"):
        experiment_on("stereo", "stereo-follow", ["quick"], ["colour_pf[particles=5]"], range(1))
