"""Learns a site from its pictures without intruders."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
from numpy.typing import NDArray

from trackers.harbour_watch.boxes import cells_of
from trackers.harbour_watch.detection import SIZES_M
from trackers.harbour_watch.existence import clutter_rates
from trackers.harbour_watch.low_rank import learn
from trackers.harbour_watch.site_model import LearntSite, ModelParameters, SiteModel
from trackers.harbour_watch.water import WaterLevel
from trackers.site.quay import shows_water
from trackers.site.reading import Picture, noise_of
from trackers.site.survey import Site

_MOST_REPLAYED = 120
_MOVED = 10.0
"""Deviations of a pixel's noise by which it changes when something that belongs there moves, e.g. a moored boat."""
_MOVES_SHARE = 0.03
"""Share of pictures on which a pixel changes much, from which something moves there."""
_FIRST_GUESS = 3.0
"""Times the noise: spread of the background before anything is known of it."""


def learn_site(pictures: Picture, site: Site, p: ModelParameters) -> LearntSite:
    """Learn from ``pictures`` (T, H, W), T >= 1, counts in order of time."""
    shape = pictures.shape[1], pictures.shape[2]
    flat = pictures.reshape(len(pictures), -1)
    low_rank = learn(flat, p.components, noise_of(pictures).ravel())
    left, coefficients = np.empty_like(flat), None
    for k, picture in enumerate(flat):
        coefficients = low_rank.coefficients(picture, coefficients)
        left[k] = picture - low_rank.explained(coefficients)
    noise = noise_of(left.reshape(pictures.shape))
    variance = noise.ravel() ** 2
    if len(pictures) == 1:
        first = _FIRST_GUESS**2 * variance
    else:
        first = np.maximum(low_rank.spread**2 - variance, 0.01 * variance)
    level = WaterLevel(site.view, shows_water(site.survey, site.view), noise, site.survey.mean_water_m)
    level.settle(pictures)
    nothing = clutter_rates(shape, p.least_score, [], np.zeros(shape, np.float32))
    boxes = np.ones((len(SIZES_M), *cells_of(shape)), np.float32)
    learnt = LearntSite(low_rank, noise, first, boxes, boxes, np.array(level.mean_rise_px), nothing)
    return learnt if len(pictures) == 1 else _replayed(learnt, left, site, p)


def _replayed(learnt: LearntSite, left: Picture, site: Site, p: ModelParameters) -> LearntSite:
    """Learn the noise of boxes and the false regions from what the background leaves of its own pictures.

    Steps from one to the next are what remains of noise once the memory follows; the pictures themselves are as
    doubtful as the first one of an episode.
    """
    model, shape = SiteModel(learnt, site, p), learnt.noise.shape
    filters, nobody = model.detector.filters, np.zeros(shape, np.uint8)
    every = max(1, (len(left) - 1) // _MOST_REPLAYED)
    noise, all_doubt = np.sqrt(2.0 * model.memory.noise), np.ones(shape, np.float32)
    steps = [((left[k + 1] - left[k]) / noise).reshape(shape) for k in range(0, len(left) - 1, every)]
    for k, step in enumerate(steps, 1):
        rate = max(1.0 / k, 0.05)
        filters.learn(filters.scaled(filters.filtered(step, p.clip)), nobody, rate)
        deviation = model.memory.deviation(left[(k - 1) * every]).reshape(shape)
        filters.learn_slow(filters.scaled(filters.filtered(deviation, p.clip), all_doubt), rate)
    found = [
        model.detector.regions(filters.scaled(filters.filtered(step, p.clip)), step, model.watched) for step in steps
    ]
    changed = _MOVED * np.sqrt(float(np.median(model.memory.noise)))
    moving = np.mean([np.abs(left[k + 1] - left[k]) > changed for k in range(0, len(left) - 1, every)], axis=0)
    moored = _moored(moving.reshape(shape).astype(np.float32), model.water)
    rates = clutter_rates((shape[0], shape[1]), p.least_score, found, moored)
    return replace(learnt, variance=filters.variance, slow_variance=filters.slow_variance, clutter=rates)


def _moored(moving: Picture, water: NDArray[np.bool_]) -> Picture:
    """Return the share of pictures (H, W) on which something moored moves, from that on which pixels change much.

    What is moored reaches down to the water.
    """
    _, labels = cv2.connectedComponents((moving > _MOVES_SHARE).astype(np.uint8))
    moored: Picture = moving * np.isin(labels, np.unique(labels[water & (labels > 0)]))
    return moored
