"""Builds, skin and hair of drawn people, against the figures that they are drawn from."""

from __future__ import annotations

import colorsys

import numpy as np
import pytest

from sim.meshes.population import draw_person


@pytest.fixture(scope="module")
def adults():
    rng = np.random.default_rng(0)
    return [draw_person(rng, children=0.0) for _ in range(3000)]


def test_adults_have_the_statures_and_breadths_of_the_survey(adults):
    statures_m = np.array([look.stature_m for look in adults])
    women = np.array([look.figure.bust > 0 for look in adults])
    for is_sex, mean_m, spread_m in ((women, 1.649, 0.065), (~women, 1.777, 0.072)):
        chosen = statures_m[is_sex]
        assert chosen.mean() == pytest.approx(mean_m, abs=4 * spread_m / np.sqrt(len(chosen)))
        assert chosen.std() == pytest.approx(spread_m, rel=0.08)
    shoulders, hips = (np.array([getattr(look.figure, name) for look in adults]) for name in ("shoulders", "hips"))
    # Biacromial over bitrochanteric breadth: 1.268 of men and 1.158 of women, 1.212 of the average figure.
    assert (shoulders / hips)[~women].mean() == pytest.approx(1.268 / 1.212, abs=0.03)
    assert (shoulders / hips)[women].mean() == pytest.approx(1.158 / 1.212, abs=0.03)
    waists = np.array([look.figure.waist for look in adults])
    assert np.percentile(waists, 95) > 1.3
    assert np.percentile(waists, 5) < 0.9


def test_dark_skin_has_dark_hair_and_light_skin_any(adults):
    def lightness(rgb):
        return colorsys.rgb_to_hls(*(level / 255 for level in rgb))[1]

    skins, hairs = (np.array([lightness(getattr(look, f"{name}_rgb")) for look in adults]) for name in ("skin", "hair"))
    is_dark = skins < np.percentile(skins, 15)
    is_light = skins > np.percentile(skins, 70)
    # Half of the adults are old enough to turn grey.
    assert (hairs[is_dark] < 0.2).mean() > 0.4
    assert (hairs[is_light] < 0.2).mean() < 0.3
    assert (hairs[is_light] > 0.3).mean() > 1.5 * (hairs[is_dark] > 0.3).mean()
    assert skins.min() < 0.33
    assert skins.max() > 0.65


def test_children_are_small_with_large_heads_and_short_legs():
    rng = np.random.default_rng(1)
    children = [draw_person(rng, children=1.0) for _ in range(300)]
    assert 1.05 <= min(look.stature_m for look in children) < 1.2
    small, tall = ([look for look in children if low < look.stature_m < high] for low, high in ((1.0, 1.25), (1.5, 2)))
    assert np.mean([look.figure.head for look in small]) > 1.15 * np.mean([look.figure.head for look in tall])
    assert np.mean([look.figure.limbs for look in small]) < np.mean([look.figure.limbs for look in tall])
    assert not any(look.beard or look.figure.bust for look in children)
    with pytest.raises(ValueError, match=r"children: expected a share in \[0, 1\], got 2"):
        draw_person(rng, children=2)
