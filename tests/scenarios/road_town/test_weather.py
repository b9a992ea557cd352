"""Light, weather and seasons of towns: truth stays, pictures change, episodes repeat."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from scenarios.road_town.plan import draw_layout
from scenarios.road_town.presets import NEXT_PRESETS, PRESETS, RoadTown
from scenarios.road_town.road_map import road_area
from scenarios.road_town.scenario import ROAD_TOWN, KeptTown, kind_of_town
from scenarios.road_town.seasons import LOOKS
from scenarios.road_town.street_lamps import lamp_heads_m
from scenarios.road_town.town import build_town
from scenarios.road_town.weather import draw_conditions
from scenarios.scenario import Frame, KeptWorld
from sim.rng import episode_seed, generator
from sim.shaders.daylight import DaylightShader

SMALL = replace(PRESETS["quick"], width_px=96, height_px=72, extent_m=300.0, lamp_posts=True)
CHANGES = {
    "clear": {},
    "overcast": {"weather": "overcast"},
    "night": {"sun_elevation_deg": (-12.0, -12.0)},
    "rain": {"weather": "rain"},
    "fog": {"weather": "fog"},
    "snow": {"weather": "snow", "snow_cover": (0.8, 0.8)},
}


@cache
def town(season: str = "summer") -> KeptWorld:
    seed = episode_seed(0, ROAD_TOWN.id, 0)
    layout = draw_layout(SMALL, seed)
    return KeptWorld(build_town(layout, generator(seed, "town"), 256, season=season), KeptTown(layout))


def frames(changes: dict, count: int = 2, seed: int = 0) -> list[Frame]:
    episode = ROAD_TOWN.episode(replace(SMALL, **changes), seed, kept=town())
    return [episode.step() for _ in range(count)]


@cache
def seen(name: str) -> list[Frame]:
    return frames(CHANGES[name])


@pytest.mark.parametrize("name", list(CHANGES)[1:])
def test_weather_changes_pictures_and_no_geometry(name):
    for clear, other in zip(seen("clear"), seen(name), strict=True):
        assert (clear.observation.image_rgb != other.observation.image_rgb).mean() > 0.5
        for field in ("instance_map", "depth_m", "box_xyxy", "visible_fraction", "T_world_object", "flow_px"):
            np.testing.assert_array_equal(getattr(clear.truth, field), getattr(other.truth, field))


@pytest.mark.parametrize("name", ["night", "rain", "snow"])
def test_an_episode_in_weather_repeats_byte_for_byte(name):
    for first, again in zip(seen(name), frames(CHANGES[name]), strict=True):
        np.testing.assert_array_equal(first.observation.image_rgb, again.observation.image_rgb)


def test_plain_daylight_is_lit_as_ever():
    episode = ROAD_TOWN.episode(SMALL, 0, kept=town())
    assert isinstance(episode._shader, DaylightShader)
    assert (episode._light.sun_illuminance_lx, episode._light.sky_illuminance_lx) == (90_000.0, 18_000.0)


def test_at_night_exposure_gain_and_noise_rise():
    day, night = (seen(name)[1].observation for name in ("clear", "night"))
    assert night.settings.exposure_s > 3 * day.settings.exposure_s
    assert night.settings.gain > 4.0 > day.settings.gain
    # White paint of lamps and beams is there, and most of the town is dark.
    levels = night.image_rgb.mean(axis=-1)
    assert np.percentile(levels, 99.5) > 120
    assert np.median(levels) < 90


def test_truth_says_what_the_weather_is():
    truth = {name: seen(name)[0].truth for name in CHANGES}
    assert [truth[name].weather for name in ("clear", "night", "rain", "fog")] == ["clear", "clear", "rain", "fog"]
    assert truth["night"].street_lamps_on
    assert truth["night"].headlights_on
    assert truth["rain"].headlights_on
    assert not truth["rain"].street_lamps_on
    assert not truth["clear"].headlights_on
    assert 150.0 <= truth["fog"].visibility_m <= 400.0
    assert np.isinf(truth["clear"].visibility_m)
    assert truth["snow"].snow_cover == 0.8
    assert truth["rain"].rain_mm_h > 0.0
    assert 1_000.0 < truth["rain"].visibility_m < 10_000.0


def test_lamps_stand_on_pavements_and_shine_over_the_street():
    layout = town().content.layout
    area = road_area(layout.graph)
    posts = np.array([lamp.centre_m for lamp in layout.lamps])
    assert len(posts) > 20
    distances = np.array([area.distance(_point(place)) for place in posts])
    assert ((distances > 0.3) & (distances < 2.0)).mean() > 0.95
    over = [area.contains(_point(place[:2])) for place in lamp_heads_m(layout.lamps)]
    assert np.mean(over) > 0.95


def _point(place_m):
    import shapely

    return shapely.Point(place_m)


def test_no_standing_preset_has_lamps_or_weather():
    for preset in PRESETS.values():
        assert not preset.has_lamp_posts
        assert preset.weather == "clear"
    assert NEXT_PRESETS["night"].has_lamp_posts


def test_what_a_kept_town_is_depends_on_what_is_drawn_into_it():
    kinds = {kind_of_town(replace(SMALL, season=season)) for season in LOOKS}
    kinds |= {kind_of_town(replace(SMALL, **changes)) for changes in CHANGES.values()}
    # Fog, night and overcast weather need no cover; night has lamps that burn.
    assert len(kinds) == len(LOOKS) + 4
    assert kind_of_town(replace(SMALL, cruise_mps=(1.0, 2.0))) == kind_of_town(SMALL)


@pytest.mark.parametrize("season", [season for season in LOOKS if season != "summer"])
def test_a_town_is_the_same_one_in_all_seasons(season):
    summer, other = town().world, town(season).world
    assert [body.name for body in summer.bodies] == [body.name for body in other.bodies]
    np.testing.assert_array_equal(summer.poses, other.poses)
    grounds = [world.bodies[0].mesh.texture.rgb.astype(float).mean(axis=(0, 1)) for world in (summer, other)]
    greens = [2 * mean[1] - mean[0] - mean[2] for mean in grounds]
    assert greens[1] > greens[0] if season == "spring" else greens[1] < greens[0]


def test_winter_has_bare_trees_within_the_bounds_of_leafy_ones():
    for summer, winter in zip(town().world.bodies, town("winter").world.bodies, strict=True):
        if summer.category == "tree":
            leafy, bare = summer.mesh.vertices_m, winter.mesh.vertices_m
            assert np.linalg.norm(bare[:, :2], axis=1).max() <= 1.1 * np.linalg.norm(leafy[:, :2], axis=1).max()
            assert bare[:, 2].max() <= 1.02 * leafy[:, 2].max()


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"sun_elevation_deg": (-91.0, 0.0)}, "sun_elevation_deg: expected two numbers in ascending order in"),
        ({"snow_cover": (0.0, 1.5)}, r"snow_cover: expected two numbers in ascending order in \[0, 1\]"),
        ({"fog_visibility_m": (0.0, 100.0)}, "fog_visibility_m: expected"),
        ({"weather": "hail"}, "weather: expected"),
    ],
)
def test_impossible_weather_is_refused(values, message):
    with pytest.raises(ValueError, match=message):
        RoadTown("x", **values)


def test_headlights_are_on_in_bad_weather_and_at_dusk():
    on = {
        (weather, elevation): draw_conditions(
            replace(SMALL, weather=weather), 0, 0.0, np.radians(elevation)
        ).headlights_on
        for weather in ("clear", "overcast", "rain", "fog")
        for elevation in (40.0, -1.0)
    }
    assert not on["clear", 40.0]
    assert not on["overcast", 40.0]
    assert all(lit for (_, elevation), lit in on.items() if elevation < 0.0)
    assert on["rain", 40.0]
    assert on["fog", 40.0]


@pytest.mark.heavy
@pytest.mark.parametrize("name", ["night", "rain"])
def test_the_reference_renderer_gives_the_same_picture(name):
    pytest.importorskip("pybullet")
    preset = replace(SMALL, width_px=160, height_px=120, **CHANGES[name])
    pictures = [
        ROAD_TOWN.episode(preset, 0, kept=town(), renderer=renderer).step().observation.image_rgb.astype(int)
        for renderer in ("raster", "pybullet")
    ]
    # Smooth textures are filtered by one alone; noise is the same.
    assert np.abs(pictures[0] - pictures[1]).mean() < 6.0
    assert np.abs(pictures[0].mean(axis=(0, 1)) - pictures[1].mean(axis=(0, 1))).max() < 1.0
