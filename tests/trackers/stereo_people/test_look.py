"""Looks and association of ``stereo_people``, whatever its parameters are."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from itertools import permutations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import multivariate_normal

from trackers.stereo_people.look import (
    PARTS,
    SIZE,
    Look,
    LookModel,
    LookParameters,
    log_levels,
    look_at,
    population_covariance,
    population_mean,
)
from trackers.stereo_people.tracks import Sighting, Track, TrackParameters, associate

STEADY = np.zeros(3)


def look_of(*parts_rgb: tuple[float, float, float]) -> Look:
    """Return a look by linear colours of head, chest, waist, thighs, shins; NaN where not seen."""
    return Look(np.log(np.array(parts_rgb)).ravel(), np.full(SIZE, 0.02))


SKIN, NAVY, OCHRE, BRICK = (0.4, 0.25, 0.18), (0.02, 0.04, 0.12), (0.4, 0.25, 0.05), (0.35, 0.05, 0.04)
TARGET = look_of(SKIN, OCHRE, OCHRE, NAVY, NAVY)
OTHER = look_of(SKIN, NAVY, NAVY, OCHRE, BRICK)
UNSEEN = Look(np.full(SIZE, np.nan), np.full(SIZE, np.inf))


def model_of(look: Look, sightings: int = 6) -> LookModel:
    model = LookModel(look, LookParameters())
    for _ in range(sightings):
        model.predict(STEADY, 0.0, is_lost=False)
        model.correct(look)
    return model


def under_light(look: Look, *log_rgb: float) -> Look:
    return replace(look, log_rgb=look.log_rgb + np.tile(log_rgb, len(PARTS)))


class TestLooks:
    def test_the_same_clothes_are_likelier_than_others(self):
        model = model_of(TARGET)
        assert model.likeness(TARGET) > 0 > model.likeness(OTHER)
        assert model.likeness(UNSEEN) == 0.0

    @pytest.mark.parametrize("light", [(0.9, 0.9, 0.9), (-0.9, -0.9, -0.9), (0.5, 0.1, -0.4)])
    def test_a_common_shift_is_forgiven_when_the_light_may_have_changed_alone(self, light):
        steady, loosened = model_of(TARGET), model_of(TARGET)
        steady.predict(STEADY, 0.0, is_lost=False)
        loosened.predict(STEADY, 3.0, is_lost=False)
        relit = under_light(TARGET, *light)
        assert loosened.likeness(relit) > steady.likeness(relit) + 1.0
        assert loosened.likeness(relit) > 0
        # Another person's look stays unlikely: no light makes the trousers darker than the top.
        assert loosened.likeness(under_light(OTHER, *light)) < loosened.likeness(relit) - 3.0

    @settings(max_examples=25, deadline=None)
    @given(seed=st.integers(0, 9999))
    def test_likeness_is_the_best_ratio_of_normal_densities_with_at_most_one_part_left_out(self, seed):
        rng = np.random.default_rng(seed)
        model = model_of(TARGET, 2)
        seen = np.repeat(rng.random(len(PARTS)) < 0.7, 3)
        log_rgb, variance = TARGET.log_rgb + rng.normal(0.0, 0.8, SIZE), rng.uniform(0.01, 0.5, SIZE)
        look = Look(np.where(seen, log_rgb, np.nan), np.where(seen, variance, np.inf))

        def ratio(used):
            def log_density(mean, covariance):
                noisy = covariance[np.ix_(used, used)] + np.diag(variance[used])
                return multivariate_normal(mean[used], noisy).logpdf(log_rgb[used])

            population = population_covariance(LookParameters())
            return log_density(model.mean, model.covariance) - log_density(population_mean(look), population)

        parts = [part for part in range(len(PARTS)) if seen[3 * part]]
        left_out = [seen & (np.arange(SIZE) // 3 != part) for part in parts] if len(parts) > 2 else []
        best = max([ratio(seen), *(ratio(each) - 3.0 for each in left_out)]) if parts else 0.0
        assert model.likeness(look) == pytest.approx(best, rel=1e-9, abs=1e-9)

    def test_a_shift_of_the_whole_picture_shifts_the_look(self):
        model = model_of(TARGET)
        before = model.mean.copy()
        model.predict(np.array([0.4, 0.3, 0.2]), 0.0, is_lost=False)
        np.testing.assert_allclose(model.mean - before, np.tile([0.4, 0.3, 0.2], len(PARTS)))
        assert model.likeness(under_light(TARGET, 0.4, 0.3, 0.2)) > 0

    @pytest.mark.parametrize("part", range(len(PARTS)))
    def test_one_part_of_another_person_costs_no_more_than_leaving_it_out(self, part):
        model = model_of(TARGET)
        odd, without = TARGET.log_rgb.copy(), TARGET.log_rgb.copy()
        odd[3 * part : 3 * part + 3] += (2.5, -1.0, 1.5)
        without[3 * part : 3 * part + 3] = np.nan
        of_odd, of_without = (model.likeness(replace(TARGET, log_rgb=each)) for each in (odd, without))
        assert of_without - 3.5 < of_odd < of_without

    @settings(max_examples=40, deadline=None)
    @given(seed=st.integers(0, 9999))
    def test_looks_shrink_the_covariance_and_keep_it_positive(self, seed):
        rng = np.random.default_rng(seed)
        model = model_of(TARGET, 0)
        for _ in range(5):
            model.predict(rng.normal(0, 0.3, 3), rng.uniform(0, 1), is_lost=bool(rng.random() < 0.5))
            loose = np.trace(model.covariance)
            seen = rng.random(SIZE) < 0.7
            look = Look(np.where(seen, model.mean, np.nan), np.where(seen, 0.05, np.inf))
            model.correct(look)
            assert np.trace(model.covariance) <= loose + 1e-9
            assert np.linalg.eigvalsh(model.covariance).min() > 0
        before = model.mean.copy()
        model.correct(UNSEEN)
        assert np.array_equal(model.mean, before)

    def test_parts_are_medians_of_the_pixels_at_their_height(self):
        heights_m = np.repeat(np.linspace(0.0, 1.75, 88, dtype=np.float32)[:, None], 20, axis=1)
        image = np.zeros((88, 20, 3), np.uint8)
        for part, (low, high) in enumerate(PARTS):
            image[(heights_m[:, 0] >= low * 1.7) & (heights_m[:, 0] < high * 1.7)] = (40 * part + 20, 90, 30)
        everything = np.arange(88 * 20)
        look = look_at(log_levels(image), heights_m, everything, 1.7, LookParameters())
        wanted = log_levels(np.array([[(40 * part + 20, 90, 30) for part in range(len(PARTS))]], np.uint8))
        np.testing.assert_allclose(look.log_rgb.reshape(-1, 3), wanted[0])
        legs = everything[heights_m.ravel() < 0.25 * 1.7]
        only = look_at(log_levels(image), heights_m, legs, 1.7, LookParameters())
        assert only.known.reshape(-1, 3).all(axis=1).tolist() == [False] * 4 + [True]


def sighting(place_m: Iterable[float], look: Look = TARGET, height_m: float = 1.75) -> Sighting:
    return Sighting(np.array(list(place_m), dtype=float), 3.0, height_m, look)


@settings(max_examples=60, deadline=None)
@given(seed=st.integers(0, 9999), people=st.integers(0, 4), seen=st.integers(0, 4))
def test_association_is_the_best_of_all(seed, people, seen):
    rng = np.random.default_rng(seed)
    looks = (TARGET, OTHER, UNSEEN)
    tracks = [
        Track(sighting(rng.uniform(0, 1.5, 2), looks[rng.integers(2)]), 0.0, TrackParameters()) for _ in range(people)
    ]
    sightings = [sighting(rng.uniform(0, 1.5, 2), looks[rng.integers(3)], rng.uniform(1.6, 1.9)) for _ in range(seen)]
    for track in tracks:
        track.predict(1 / 15, STEADY, 0.0)
    scores = np.array([[track.score(each) for each in sightings] for track in tracks]).reshape(people, seen)
    found = associate(tracks, sightings)
    assert len(found) == people
    taken = [index for index in found if index is not None]
    assert len(set(taken)) == len(taken)
    assert all(scores[row, index] > 0 for row, index in enumerate(found) if index is not None)
    padded = np.zeros((people, seen + people))
    padded[:, :seen] = np.maximum(scores, 0.0)
    best = max(padded[np.arange(people), list(order)].sum() for order in permutations(range(seen + people), people))
    assert sum(scores[row, index] for row, index in enumerate(found) if index is not None) == pytest.approx(best)


def test_a_sighting_too_far_off_has_no_track():
    track = Track(sighting((3.0, 0.0)), 0.0, TrackParameters())
    track.predict(1 / 15, STEADY, 0.0)
    assert track.score(sighting((3.1, 0.0))) > 0
    assert track.score(sighting((9.0, 0.0))) == -np.inf
    assert track.score(sighting((3.1, 0.0), OTHER)) < track.score(sighting((3.1, 0.0)))
    assert track.score(sighting((3.1, 0.0), height_m=1.55)) < track.score(sighting((3.1, 0.0)))
