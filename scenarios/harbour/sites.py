"""Harbours by number: quays, camera, sheds, cranes, berths."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from scenarios.harbour.layout import FIXED, GAP_Y_M, OPEN_BAYS_Y_M, Berth, Goods, Shed, Site, Wing
from scenarios.harbour.presets import BY_SEED, Harbour
from scenarios.scenario import Setup
from sim.rng import episode_seed, generator
from trackers.types import CameraModel

_SPAN_M = 260.0
_FREE_HALF_M = 11.0
"""Of the free berth's wall, along which visitors come and go."""
_CLEAR_M = 19.0
"""From the free berth to the next wing, so that boats can turn."""


def site_of(preset: Harbour, setup: Setup) -> Site:
    """Return the harbour of an episode."""
    if preset.site == "fixed":
        return FIXED
    if preset.site == BY_SEED:
        return draw_site(setup.day_rng("site"))
    return draw_site(generator(episode_seed(int(preset.site), "harbour site", 0), "site"))


def draw_site(rng: np.random.Generator) -> Site:
    """Draw a harbour whose camera looks across the quay, obliquely onto it, or along it."""
    looks = str(rng.choice(["across", "obliquely", "along"], p=[0.3, 0.35, 0.35]))
    side = float(rng.choice([-1.0, 1.0]))
    bearing_deg = {
        "across": rng.uniform(0.0, 20.0),
        "obliquely": rng.uniform(22.0, 48.0),
        "along": rng.uniform(80.0, 97.0),
    }
    bearing = side * float(np.radians(bearing_deg[looks]))
    high_m, away_m = rng.uniform(10.0, 24.0), rng.uniform(60.0, 100.0)
    if looks == "along":
        high_m, away_m = rng.uniform(8.0, 18.0), rng.uniform(38.0, 70.0)
    width_m = away_m * rng.uniform(0.5, 0.72)
    camera = CameraModel(384, 288, float(384 * away_m / width_m), band="thermal")
    place = (float(-away_m * np.cos(bearing)), float(-away_m * np.sin(bearing)), float(high_m))
    # The middle of the picture is on the apron.
    apron_m = rng.uniform(20.0, 34.0)
    wall_x = -float(rng.uniform(0.35, 0.6)) * apron_m
    if looks == "along":
        wall_x = -float(rng.uniform(0.2, 0.45)) * min(apron_m, width_m)
    apron_end, shed_x = wall_x + apron_m, wall_x + apron_m + 34.0
    free_y = float(rng.uniform(-7.0, 5.0))
    wings = _wings(wall_x, free_y, rng)
    tip = min((each.tip_x_m for each in wings), default=wall_x)
    fairway = (tip - 12.0, tip - 7.5)
    shut = {int(side): float(rng.uniform(42.0, 75.0))} if looks == "along" else {}
    walks = float(np.clip(0.36 * (width_m if looks != "along" else 1.2 * away_m), 12.0, 24.0))
    site = Site(
        camera=camera,
        camera_m=place,
        volume_m=(round(0.9 * away_m, 1), round(0.66 * width_m, 1), 6.0),
        wall_x_m=wall_x,
        apron_end_m=apron_end,
        shed_x_m=shed_x,
        sheds=_sheds(rng),
        berths=_berths(wall_x, free_y, wings, rng),
        buoys_m=tuple((tip - off, y) for off, y in ((rng.uniform(20.0, 28.0), 8.0), (rng.uniform(22.0, 32.0), -9.0))),
        lamp_posts_m=_lamps(apron_end, shed_x, rng),
        wings=wings,
        bollards_y_m=tuple(np.arange(-60.0, 61.0, float(rng.uniform(5.0, 9.0))).tolist()),
        fairway_x_m=fairway,
        walks_y_m=walks,
        span_m=_SPAN_M,
        shut_y_m=shut,
        is_drawn=True,
    )
    return replace(site, goods=_goods(site, rng))


def _wings(wall_x: float, free_y: float, rng: np.random.Generator) -> tuple[Wing, ...]:
    """Draw a straight quay, an L, a basin between two wings, or a narrow pier."""
    kind = str(rng.choice(["straight", "L", "basin", "pier"], p=[0.3, 0.25, 0.2, 0.25]))
    side = float(rng.choice([-1.0, 1.0]))
    sides = {"straight": (), "L": (side,), "basin": (-1.0, 1.0), "pier": (side,)}[kind]
    wings = []
    for one in sides:
        near = free_y + one * (_CLEAR_M + rng.uniform(0.0, 8.0))
        wide = rng.uniform(3.0, 5.0) if kind == "pier" else rng.uniform(9.0, 26.0)
        long = rng.uniform(18.0, 30.0) if kind == "pier" else rng.uniform(24.0, 48.0)
        low, high = sorted((near, near + one * wide))
        wings.append(Wing(wall_x - float(long), float(low), float(high)))
    return tuple(wings)


def _berths(wall_x: float, free_y: float, wings: tuple[Wing, ...], rng: np.random.Generator) -> tuple[Berth, ...]:
    """Draw berths along the main edge and along the inner sides of wings; one is free."""
    berths = [Berth(free_y, float(rng.choice([-0.5, 0.5])) * np.pi, True)]
    for way in (-1.0, 1.0):
        y = free_y + way * (_FREE_HALF_M + rng.uniform(0.0, 3.0))
        while abs(y) < 46.0:
            if all(y < each.low_y_m - 7.0 or y > each.high_y_m + 7.0 for each in wings) and rng.random() < 0.6:
                berths.append(Berth(float(y), float(rng.choice([-0.5, 0.5])) * np.pi, False))
            y += way * rng.uniform(10.5, 13.5)
    for wing in wings:
        inner = 1.0 if wing.high_y_m < free_y else -1.0
        # On the side away from the free berth boats turn nowhere.
        outer_y, off = (wing.low_y_m, -1.0) if inner > 0.0 else (wing.high_y_m, 1.0)
        x = wall_x - rng.uniform(7.0, 9.0)
        while x > wing.tip_x_m + 5.0:
            if rng.random() < 0.7:
                heading = float(rng.choice([0.0, np.pi]))
                berths.append(Berth(float(outer_y), heading, False, (0.0, off), float(x)))
            x -= rng.uniform(10.5, 13.0)
    return tuple(berths)


def _sheds(rng: np.random.Generator) -> tuple[Shed, ...]:
    """Draw a row of sheds and warehouses on both sides of the road between them."""
    sheds = []
    for way in (-1.0, 1.0):
        y = GAP_Y_M + way * rng.uniform(6.0, 9.0)
        while abs(y) < 130.0:
            long, is_tall = float(rng.uniform(16.0, 42.0)), bool(rng.random() < 0.25)
            eaves = float(rng.uniform(7.0, 11.0) if is_tall else rng.uniform(3.4, 5.2))
            rise = 0.0 if is_tall and rng.random() < 0.6 else float(rng.uniform(1.2, 3.0))
            middle = y + way * 0.5 * long
            doors = np.arange(-0.5 * long + 3.5, 0.5 * long - 6.5, float(rng.uniform(6.5, 11.0)))
            depth = float(rng.uniform(10.0, 16.0))
            sheds.append(Shed(float(middle), long, depth, eaves, rise, tuple((middle + doors).tolist())))
            y += way * (long + float(rng.choice([0.3, rng.uniform(3.0, 9.0)])))
    return tuple(sheds)


def _lamps(apron_end: float, shed_x: float, rng: np.random.Generator) -> tuple[tuple[float, float], ...]:
    step, first = float(rng.uniform(22.0, 34.0)), float(rng.uniform(4.0, 9.0))
    posts = [(apron_end - 1.0, way * (first + k * step)) for way in (-1.0, 1.0) for k in range(4)]
    return (*posts, *((shed_x - 8.0, y + 3.0) for _, y in posts[::2]))


def _goods(site: Site, rng: np.random.Generator) -> tuple[Goods, ...]:
    """Draw what lies about on the apron and on wide wings, off the ways of cars and some metres apart."""
    goods: list[Goods] = []
    low, high = min(OPEN_BAYS_Y_M) - 9.0, max(OPEN_BAYS_Y_M) + 9.0
    for _ in range(int(rng.integers(30, 90))):
        near = bool(rng.random() < 0.35)
        x = site.wall_x_m + float(
            rng.uniform(4.0, 6.0) if near else rng.uniform(6.5, site.apron_end_m - site.wall_x_m - 3.0)
        )
        y, radius = float(rng.uniform(-70.0, 70.0)), float(rng.choice([0.9, 1.5]))
        ahead_m = float(site.volume_axes[0] @ np.subtract((x, y), site.camera_m[:2]))
        if ahead_m < 16.0 or (not near and low < y < high):
            continue
        if all(np.hypot(x - each.x_m, y - each.y_m) > 6.0 for each in goods):
            goods.append(Goods(x, y, radius))
    for wing in site.wings:
        if wing.high_y_m - wing.low_y_m > 8.0:
            for x in np.arange(wing.tip_x_m + 5.0, site.wall_x_m - 3.0, float(rng.uniform(6.0, 11.0))).tolist():
                goods.append(Goods(x, float(rng.uniform(wing.low_y_m + 3.0, wing.high_y_m - 3.0)), 1.5))
    return tuple(goods)
