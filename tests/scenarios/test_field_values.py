"""Names of presets with other values: what they say, what is drawn, and what is refused."""

from __future__ import annotations

import dataclasses
import re
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from benchmarks.data.sequence_names import set_name
from benchmarks.run.episodes import simulated
from scenarios import catalog
from scenarios.envs.settings import FollowSettings
from scenarios.field_values import changeable, is_drawn, split_name, with_values

TOWN = catalog.scenario("road-town")


def drawn_values(setting: str, name: str, count: int = 200) -> list[Any]:
    """Return a field's value in several episodes."""
    return [getattr(TOWN.configuration(with_values("standard", [setting]), seed), name) for seed in range(count)]


def test_a_name_says_its_values_in_one_order() -> None:
    name = with_values("standard", ["traffic_cars=4:24", "driver=choice(idm, idm)"])
    assert name == "standard[driver=choice(idm,idm),traffic_cars=4:24]"
    assert with_values(name, []) == name
    assert with_values(name, ["traffic_cars=5"]) == "standard[driver=choice(idm,idm),traffic_cars=5]"
    assert split_name(name) == ("standard", {"driver": "choice(idm,idm)", "traffic_cars": "4:24"})
    assert split_name("standard") == ("standard", {})
    assert with_values("standard", []) == "standard"
    assert set_name("road-town-v2", name) == "road-town-v2-standard_driver_choice_idm_idm_traffic_cars_4_24"


def test_an_empty_list_has_nothing_in_it() -> None:
    with pytest.raises(ValueError, match=r"building_models: expected one model at least, got \(\)"):
        TOWN.configuration("standard[building_models=[]]")


def test_names_of_many_changes_are_no_longer_than_files_may_be_called() -> None:
    name, other = (
        with_values(
            "standard",
            [f"{field}=uniform({low},{k}.5)" for k, field in enumerate(changeable(TOWN.presets["standard"]))],
        )
        for low in (1, 2)
    )
    names = set_name("road-town-v2", name), set_name("road-town-v2", other)
    assert [len(each) for each in names] == [120, 120]
    assert len({*names}) == 2
    assert names[0].startswith("road-town-v2-standard_")


@given(st.sampled_from([name for name in changeable(TOWN.presets["standard"]) if name not in ("frame_outs", "ego")]))
def test_a_preset_s_own_values_change_nothing(name: str) -> None:
    """Of every field, written as JSON."""
    preset = TOWN.presets["standard"]
    text = re.sub(r"^\((.*)\)$", r"[\1]", str(getattr(preset, name))).replace("'", '"').replace("False", "false")
    text = text.replace("True", "true").replace(",]", "]")
    assert TOWN.configuration(with_values("standard", [f"{name}={text}"])) == preset


def test_values_have_the_kind_of_the_field() -> None:
    made = TOWN.configuration("standard[rate_hz=10,altitude_m=60,street_patterns=[grid,ring],frame_outs.count=1]")
    assert (type(made.rate_hz), made.rate_hz) == (float, 10.0)
    assert made.altitude_m == (60.0, 60.0)
    assert made.frame_outs == dataclasses.replace(TOWN.presets["standard"].frame_outs, count=(1, 1))
    assert TOWN.configuration("standard[altitude_m=55:70]").altitude_m == (55.0, 70.0)


def test_draws_have_their_distributions() -> None:
    cars = drawn_values("traffic_cars=4:7", "traffic_cars")
    assert set(cars) == {4, 5, 6, 7}
    counts = np.bincount(cars)[4:]
    # Within four standard deviations of a binomial count.
    assert np.abs(counts - 50).max() < 4 * np.sqrt(200 * 0.25 * 0.75)
    share = np.array(drawn_values("stop_share=uniform(0.2,0.6)", "stop_share"))
    assert 0.2 <= share.min() < 0.25 < 0.55 < share.max() <= 0.6
    rate = np.log(drawn_values("rate_hz=log_uniform(5,20)", "rate_hz"))
    assert np.median(rate) == pytest.approx(np.log(10), abs=0.12)
    noise = np.array(drawn_values("attitude_noise_deg=normal(2,0.1)", "attitude_noise_deg"))
    assert (noise.mean(), noise.std()) == (pytest.approx(2.0, abs=0.03), pytest.approx(0.1, abs=0.02))
    assert set(drawn_values("traffic_side=choice(left,right)", "traffic_side")) == {"left", "right"}
    # A range that is drawn is a number at both ends.
    assert all(low == high for low, high in drawn_values("altitude_m=uniform(50,80)", "altitude_m", 10))


def test_a_draw_depends_on_the_seed_and_its_own_name_alone() -> None:
    alone, beside = (drawn_values(f"traffic_cars=4:24{more}", "traffic_cars", 30) for more in ("", ",stop_share=0:1"))
    assert alone == beside
    name = "quick[traffic_cars=4:24]"
    assert simulated("road-town-v2", name, 3).configuration == TOWN.configuration(name, 3)


@pytest.mark.parametrize(
    ("setting", "message"),
    [
        ("traffic=3", r"set: expected one of .*; got 'traffic' \(did you mean traffic_side\?\)"),
        ("summary=x", "set: expected one of width_px.*; got 'summary'"),
        ("traffic_cars", "set: expected FIELD=VALUE, got 'traffic_cars'"),
        ("traffic_cars=", "set: expected FIELD=VALUE"),
        ("traffic_cars=many", "traffic_cars: expected int, got 'many'"),
        ("traffic_cars=24:4", "set traffic_cars: expected two numbers in ascending order, got 24:4"),
        ("traffic_cars=uniform(3)", r"set traffic_cars: expected two numbers in uniform, got uniform\(3\)"),
        ("rate_hz=log_uniform(0,3)", "set rate_hz: expected numbers > 0"),
        ("rate_hz=normal(15,-1)", "set rate_hz: expected a deviation >= 0"),
        ("rate_hz=evenly(1,2)", "set rate_hz: expected one of uniform, log_uniform, normal, choice; got 'evenly'"),
        ("traffic_side=0:3", "set traffic_side: expected a value, since it is no number, got 0:3"),
        ("rate_hz.mean=3", "set: expected a field without parts: rate_hz, got 'rate_hz.mean'"),
        ("rate_hz=-3", r"rate_hz: expected a number in \[0.01, 1000\], got -3"),
    ],
)
def test_a_value_that_cannot_be_is_refused(setting: str, message: str) -> None:
    with pytest.raises(ValueError, match=f"^{message}"):
        TOWN.configuration(with_values("standard", [setting]))


def test_words_keep_their_spaces_and_what_may_be_nothing_takes_a_range() -> None:
    harbour = catalog.scenario("harbour-v1")
    one = harbour.configuration(with_values("standard", ["site = by seed", "swell_period_s= 3.2 : 5", "swell_m=0.5:1"]))
    assert (one.site, one.swell_period_s, one.swell_m) == ("by seed", (3.2, 5.0), (0.5, 1.0))
    assert not is_drawn(harbour.presets["standard"], "standard[swell_period_s=3.2:5]")
    assert harbour.configuration("standard[swell_period_s=null]") == harbour.presets["standard"]
    with pytest.raises(ValueError, match=r"^set swell_period_s: expected A:B or null, got 4$"):
        harbour.configuration("standard[swell_period_s=4]")
    with pytest.raises(ValueError, match="start_frame"):
        TOWN.configuration("standard[start_frame=1:2]")


def test_envs_take_values_and_leave_draws_to_randomise() -> None:
    settings = FollowSettings("road-town-v2", "colour_pf", preset="quick[traffic_cars=3]")
    assert settings.configuration({}).traffic_cars == 3
    for values, drawn in (("traffic_cars=3", False), ("altitude_m=55:70", False), ("altitude_m=uniform(55,70)", True)):
        assert is_drawn(TOWN.presets["quick"], f"quick[{values}]") == drawn
    FollowSettings("road-town-v2", "colour_pf", preset="quick[altitude_m=55:70]")
    with pytest.raises(ValueError, match=r"^preset: expected fixed values, as `randomise` draws them"):
        FollowSettings("road-town-v2", "colour_pf", preset="quick[traffic_cars=3:5]")
