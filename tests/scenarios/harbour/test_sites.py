"""Harbours by number: what moves keeps to land or water, comes from where it is not seen; the survey is true."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
import pytest

from scenarios.harbour.layout import FIXED, Site
from scenarios.harbour.plan import draw_plan
from scenarios.harbour.presets import PRESETS
from scenarios.harbour.ptz import MOUNT, WIDEST_VIEW_M
from scenarios.harbour.ptz import PRESETS as PTZ_PRESETS
from scenarios.harbour.scenario import HARBOUR
from scenarios.harbour.sites import draw_site
from sim.rng import generator
from trackers.site import off_edge_m, place
from trackers.types import SiteSurvey

SITES = [draw_site(generator(seed, "site")) for seed in range(24)]
BUSY = replace(PRESETS["sites"], frame_count=900, people=20, cars=6, boats=4, deliveries=2)
SMALL = "sites[background=0,frame_count=3,people=4]"


def test_sites_differ_in_quay_and_camera() -> None:
    assert {len(site.wings) for site in SITES} == {0, 1, 2}
    assert {len(site.shut_y_m) for site in SITES} == {0, 1}
    bearings_deg = np.degrees([site.bearing_rad for site in SITES])
    assert bearings_deg.min() < -70.0
    assert bearings_deg.max() > 70.0
    assert np.ptp([site.camera_m[2] for site in SITES]) > 8.0
    assert np.ptp([site.camera.focal_px for site in SITES]) > 100.0
    assert len({len(site.berths) for site in SITES}) > 3


def test_the_middle_of_the_picture_is_on_the_quay_and_people_go_where_it_shows() -> None:
    for site in SITES:
        assert site.sees((0.0, 0.0))
        assert site.is_land(np.zeros(2))


@pytest.mark.parametrize("site", SITES)
def test_boats_keep_to_the_water_and_others_to_the_land(site: Site) -> None:
    plan = draw_plan(BUSY, generator(1, "plan"), None, site)
    for visit in plan.visits:
        begin, end = max(visit.begin_s, -100.0), min(visit.end_s, 1800.0)
        at_m, _, _ = visit.journey.at(np.linspace(begin, end, 300))
        if visit.kind == "boat":
            assert not site.is_land(at_m, margin_m=1.2).any()
        else:
            assert site.is_land(at_m).all()


@pytest.mark.parametrize("site", SITES)
def test_goods_lie_on_the_quay_and_nobody_walks_or_drives_through_them(site: Site) -> None:
    goods = np.array(site.goods)
    assert len(goods) >= 4
    assert site.is_land(goods[:, :2]).all()
    for visit in draw_plan(BUSY, generator(1, "plan"), None, site).visits:
        at_m, _, _ = visit.journey.at(np.linspace(max(visit.begin_s, -100.0), min(visit.end_s, 1900.0), 2000))
        away_m = np.hypot(*(at_m[:, None] - goods[None, :, :2]).transpose(2, 0, 1)) - goods[:, 2]
        # Who walks beside another goes nearer, and a car is wide.
        assert away_m.min() > (-0.3 if visit.kind == "person" else 0.9), visit.kind


@pytest.mark.parametrize("site", SITES)
def test_who_comes_is_not_seen_before(site: Site) -> None:
    """Each begins outside the picture, inside a building, at the door of a car, or behind the mole."""
    plan = draw_plan(BUSY, generator(2, "plan"), None, site)
    for visit in plan.visits:
        if visit.begin_s <= 0.0:
            continue
        ((x, y),) = visit.journey.at(np.array([visit.begin_s]))[0]
        by_car = visit.kind == "person" and site.apron_end_m - 30.0 < x < site.parking_x_m + 3.0
        inside = x > site.shed_x_m or any(side * y > shut for side, shut in site.shut_y_m.items())
        assert by_car or inside or not site.sees((x, y)), (visit.kind, x, y)


@pytest.mark.parametrize("site", SITES)
def test_the_survey_says_where_land_and_watched_volume_are(site: Site) -> None:
    rng = generator(3, "points")
    points = rng.uniform((-90.0, -70.0, -3.0), (60.0, 70.0, 4.0), (3000, 3))
    off_m = off_edge_m(site.survey, points)
    np.testing.assert_array_equal(off_m < 0.0, site.is_land(points[:, :2]))
    near = points[:, :2] + np.array([0.0, 0.3])
    assert (np.abs(off_edge_m(site.survey, near) - off_m) < 0.3 + 1e-9).all()
    volume = place(site.survey, site.camera, site.overview_pose())
    np.testing.assert_array_equal(volume.contains(points), site.is_watched(points))


def test_a_straight_edge_is_the_one_corner_after_the_other() -> None:
    points = generator(4, "points").uniform(-60.0, 60.0, (500, 2))
    x, survey = FIXED.wall_x_m, FIXED.survey
    as_outline = replace(survey, outline_m=((x, -90.0), (x, 10.0), (x, 90.0)))
    np.testing.assert_allclose(off_edge_m(as_outline, points), off_edge_m(survey, points), atol=1e-9)


@pytest.mark.parametrize("outline_m", [((0.0, 1.0),), ((0.0, 1.0), (np.nan, 2.0)), ((1.0,), (2.0,))])
def test_an_outline_without_corners_is_refused(outline_m: tuple[tuple[float, float], ...]) -> None:
    with pytest.raises(ValueError, match="outline_m: expected none or at least two corners"):
        SiteSurvey((0.0, 0.0), (1.0, 0.0), -1.0, (9.0, 9.0, 9.0), 0.0, outline_m)


@pytest.mark.parametrize("site", SITES)
def test_the_head_reaches_whom_it_follows(site: Site) -> None:
    """Wherever those are who walk about: by pan and tilt, and with a lens so long that the view counts."""
    (ahead, left), preset = site.volume_axes, PTZ_PRESETS["sites"]
    visits = [each for each in draw_plan(preset, generator(4, "plan"), None, site).visits if each.kind == "person"]
    for visit in visits[: preset.patrols]:
        at_m, _, _ = visit.journey.at(np.linspace(0.0, preset.frame_count / preset.rate_hz, 60))
        away_m = at_m - site.camera_m[:2]
        pan = np.arctan2(away_m @ left, away_m @ ahead)
        tilt = np.arctan2(0.9 - site.camera_m[2], np.hypot(*away_m.T))
        assert np.abs(pan).max() < MOUNT.widest_pan_rad
        assert MOUNT.tilt_rad[0] < tilt.min() <= tilt.max() < MOUNT.tilt_rad[1]
        distance_m = np.hypot(np.hypot(*away_m.T), site.camera_m[2]).max()
        longest_px = MOUNT.lens.focal_px * MOUNT.zoom[1]
        assert MOUNT.lens.width_px / longest_px * distance_m < WIDEST_VIEW_M


def test_a_number_is_one_harbour_whatever_the_seed() -> None:
    first, second, other = (
        HARBOUR.episode(f"sites[background=0,site={k}]", seed) for k, seed in ((7, 1), (7, 2), (8, 1))
    )
    assert first.start.site == second.start.site != other.start.site
    assert HARBOUR.episode("quick[background=0]", 1).start.site == FIXED.survey
    with pytest.raises(ValueError, match="site: expected 'fixed', 'by seed' or a whole number >= 0, got 'here'"):
        HARBOUR.configuration("sites[site=here]")


@pytest.mark.heavy
@pytest.mark.parametrize("seed", [7])
def test_swell_is_seen_at_noon_on_water_that_is_not_black(seed: int) -> None:
    spread = {}
    for swell_m in (0.0, 0.5):
        noon = replace(PRESETS["swell"], start_h=(13.0, 13.0), swell_m=(swell_m, swell_m), background=0, frame_count=3)
        episode = HARBOUR.episode(noon, seed, background=False)
        frame = episode.step()
        is_sea = (frame.truth.instance_map == episode._clutter.sea.index).astype(np.uint8)  # type: ignore[attr-defined]
        grey = frame.observation.image_rgb[..., 0].astype(np.float32)
        open_sea = cv2.erode(is_sea, np.ones((15, 15), np.uint8)) > 0
        assert np.median(grey[open_sea]) > 30.0
        # Noise and ripples are finer than swell.
        spread[swell_m] = float(cv2.blur(grey, (9, 9))[open_sea].std())
    assert spread[0.5] > 1.3 * spread[0.0], spread


@pytest.mark.heavy
@pytest.mark.parametrize("seed", [0, 3])
def test_both_renderers_show_the_same_sites(seed: int) -> None:
    ours, other = (HARBOUR.episode(SMALL, seed, renderer=each).step() for each in ("raster", "pybullet"))
    differ = ours.truth.instance_map != other.truth.instance_map
    assert differ.mean() < 1e-3
    off = np.abs(ours.observation.counts.astype(float) - other.observation.counts.astype(float))
    assert np.median(off) < 5.0
