"""``harbour_mog2``, ``harbour_knn`` and ``harbour_median``: what differs from a background, standing on the ground.

What an engineer would try first on a thermal camera at rest: a background subtractor, morphology, blobs projected onto
the quay and the water by the camera's calibration and the site's survey, and one linker for all three.

All three read what ``harbour_watch`` reads, the 14-bit counts, and get the same survey of the site. With the picture
after automatic gain control each found less at the same false alarms: on development seeds 20 and 21 of ``paper-d`` the
area under the FROC curve was smaller by 0.18 for the median and by 0.03 for KNN, and for MOG2 by 0.01 with a former
confidence. Beside the input only MOG2's history and the median's threshold were compared there, two values of each.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import cv2
import numpy as np
from numpy.typing import NDArray

from trackers.baselines.ground_linker import (
    EVIDENCE,
    BlobParameters,
    GroundLinker,
    LinkParameters,
    blobs_of,
    learnt_weights,
)
from trackers.registry import register, tunable
from trackers.site import Picture, Site, Surveyed, noise_of, reading_of
from trackers.types import CameraModel, Observation, Track

_NORMAL_MAD = 1.4826
_MIDDLE_LEVEL = 128.0
"""Level of the picture's median in 8 bits."""


class Subtractor(Protocol):
    """A method of background subtraction."""

    def apply(self, levels: Picture) -> tuple[NDArray[np.uint8], Picture]:
        """Take in a picture (H, W); return its foreground (H, W), not 0 where something is, and the background."""
        ...


@dataclass(frozen=True)
class ForegroundParameters(BlobParameters, LinkParameters):
    """Parameters that the three baselines share.

    Attributes:
        use_counts: False reads the picture after automatic gain control instead.
        levels_per_noise: levels of the method to one standard deviation of the camera's noise.
    """

    use_counts: bool = True
    levels_per_noise: float = tunable(1.0, 0.5, 8.0, log=True)


class _Foreground(Surveyed):
    """A ``SiteTracker`` of what a subtractor takes for foreground.

    A picture is read as levels: what it is above its median, in units of the camera's noise. The median takes away what
    the camera's drift and gain control add to all pixels. The contrast of a blob is measured in the noise of each pixel
    from one picture of the background to the next. It ranks the answers and finds nothing.

    Attributes:
        name: under which its confidences are stored.
        decides_at: see ``DecidingTracker``. Confidences are those of as many intruders as others.
    """

    name: str
    decides_at = 0.5

    def __init__(self, parameters: ForegroundParameters, rng: np.random.Generator) -> None:
        self._parameters, self._rng = parameters, rng
        self._begin((), None)

    def _subtractor(self, samples: Sequence[Picture]) -> Subtractor:
        """Return the method, which has learnt from pictures of the background."""
        raise NotImplementedError

    def start(self, background: Sequence[Observation], camera: CameraModel) -> None:
        """See ``MultiTracker``."""
        p, size = self._parameters, (camera.height_px, camera.width_px)
        shown = [reading_of(each, p.use_counts) for each in background]
        self._begin([each for each in shown if each.shape == size], self._site_of(camera, background))

    @property
    def evidence(self) -> NDArray[np.float64]:
        """(N, 11) for the N tracks of the latest answer, see ``ground_linker.evidence_of``."""
        return np.empty((0, len(EVIDENCE))) if self._linker is None else self._linker.evidence

    def _begin(self, pictures: Sequence[Picture], site: Site | None) -> None:
        self._method: Subtractor | None = None
        if pictures:
            self._learn(pictures)
        self._site = site
        self._linker: GroundLinker | None = None

    def _learn(self, pictures: Sequence[Picture]) -> None:
        noise = noise_of(np.array(pictures))
        self._unit = float(np.median(noise)) / self._parameters.levels_per_noise
        self._noise = noise / self._unit
        self._method = self._subtractor([self._levels(each) for each in pictures])

    def _levels(self, picture: Picture) -> Picture:
        levels: Picture = (picture - np.median(picture)) / np.float32(self._unit)
        return levels

    def update(self, observation: Observation) -> list[Track]:
        """See ``MultiTracker``. A picture of another size than the first one learnt has no answer."""
        p, camera = self._parameters, observation.camera
        picture = reading_of(observation, p.use_counts)
        if self._method is None:
            self._learn([picture])
        assert self._method is not None
        if picture.shape != self._noise.shape:
            return []
        if self._site is None:
            self._site = self._site_of(camera, [observation])
        levels = self._levels(picture)
        foreground, background = self._method.apply(levels)
        if self._site is None:
            return []
        if self._linker is None:
            self._linker = GroundLinker(p, self._site.view, learnt_weights(self.name))
        contrast = np.abs(levels - background) / self._noise
        return self._linker.follow(blobs_of(foreground, contrast, self._site, p), observation.time_s)


def median_and_noise(samples: Picture, least: float) -> tuple[Picture, Picture]:
    """Return the median (H, W) of samples (H, W, N), the upper one of two, and their robust standard deviation (H, W).

    The latter is 1.48 times the median absolute deviation, at least ``least``.
    """
    half = samples.shape[-1] // 2
    middle = np.partition(samples, half, axis=-1)[..., half]
    away = np.partition(np.abs(samples - middle[..., None]), half, axis=-1)[..., half]
    return middle, np.maximum(_NORMAL_MAD * away, least).astype(np.float32)


class _OfOpenCV:
    """MOG2 or KNN, which learn from every picture; OpenCV's KNN takes no more than 8 bits."""

    def __init__(
        self, method: cv2.BackgroundSubtractor, samples: Sequence[Picture], rng: np.random.Generator, in_8_bits: bool
    ) -> None:
        self._method, self._rng, self._in_8_bits = method, rng, in_8_bits
        for levels in samples:
            self._take_in(levels)

    def _take_in(self, levels: Picture) -> NDArray[np.uint8]:
        # KNN draws the samples that it renews from OpenCV's own generator, which all of a process share.
        cv2.setRNGSeed(int(self._rng.integers(1 << 31)))
        shifted = levels + np.float32(_MIDDLE_LEVEL)
        taken = np.clip(np.round(shifted), 0, 255).astype(np.uint8) if self._in_8_bits else shifted
        foreground: NDArray[np.uint8] = self._method.apply(taken)
        return foreground

    def apply(self, levels: Picture) -> tuple[NDArray[np.uint8], Picture]:
        foreground = self._take_in(levels)
        return foreground, self._method.getBackgroundImage().astype(np.float32) - np.float32(_MIDDLE_LEVEL)


@dataclass(frozen=True)
class Mog2Parameters(ForegroundParameters):
    """Parameters of ``harbour_mog2``; history and threshold are those of OpenCV.

    Attributes:
        history: pictures over which it learns.
        threshold: squared Mahalanobis distance of foreground.
    """

    levels_per_noise: float = tunable(2.0, 0.5, 8.0, log=True)
    history: int = tunable(500, 50, 3000, log=True)
    threshold: float = tunable(16.0, 4.0, 100.0, log=True)


@register("harbour_mog2", role="baseline", summary="OpenCV's MOG2 on 14-bit counts, blobs linked", suites=("harbour",))
class HarbourMog2(_Foreground):
    """Zivkovic, Improved adaptive Gaussian mixture model for background subtraction, ICPR 2004, as in OpenCV.

    Reads the counts. OpenCV's limits of the variance are those of 8-bit pictures, so the noise is put at 2 levels: its
    variance is their lower limit of 4. With a history of 2000 pictures it found less on the development seeds.
    """

    name = "harbour_mog2"
    Parameters = Mog2Parameters
    _parameters: Mog2Parameters

    def _subtractor(self, samples: Sequence[Picture]) -> Subtractor:
        p = self._parameters
        method = cv2.createBackgroundSubtractorMOG2(p.history, p.threshold, detectShadows=False)
        return _OfOpenCV(method, samples, self._rng, in_8_bits=False)


@dataclass(frozen=True)
class KnnParameters(ForegroundParameters):
    """Parameters of ``harbour_knn``; history and threshold are those of OpenCV.

    Attributes:
        history: pictures over which it learns.
        threshold: squared distance in levels from which on a sample is not near.
    """

    history: int = tunable(500, 50, 3000, log=True)
    threshold: float = tunable(400.0, 40.0, 4000.0, log=True)


@register(
    "harbour_knn", role="baseline", summary="OpenCV's KNN on counts cut to 8 bits, blobs linked", suites=("harbour",)
)
class HarbourKnn(_Foreground):
    """Zivkovic and van der Heijden, Efficient adaptive density estimation per image pixel, 2006, as in OpenCV.

    Reads the counts by a fixed gain in 8 bits, since OpenCV's KNN takes no more: without the steps of gain control.
    """

    name = "harbour_knn"
    Parameters = KnnParameters
    _parameters: KnnParameters

    def _subtractor(self, samples: Sequence[Picture]) -> Subtractor:
        p = self._parameters
        method = cv2.createBackgroundSubtractorKNN(p.history, p.threshold, detectShadows=False)
        return _OfOpenCV(method, samples, self._rng, in_8_bits=True)


@dataclass(frozen=True)
class MedianParameters(ForegroundParameters):
    """Parameters of ``harbour_median``.

    Attributes:
        samples: pictures that the median is of.
        renew_pictures: after so many the oldest sample is replaced.
        threshold: noise, as a robust standard deviation of each pixel's samples, from which on it is foreground.
    """

    samples: int = tunable(60, 10, 120)
    renew_pictures: int = tunable(20, 1, 60)
    threshold: float = tunable(5.0, 2.0, 15.0, log=True)


class _Median:
    """The median of each pixel over samples that are slowly renewed, and its noise."""

    def __init__(self, parameters: MedianParameters, pictures: Sequence[Picture]) -> None:
        self._parameters = parameters
        count = min(parameters.samples, len(pictures))
        self._samples = [pictures[k] for k in np.linspace(0, len(pictures) - 1, count).astype(int)]
        self._pictures = 0

    def apply(self, levels: Picture) -> tuple[NDArray[np.uint8], Picture]:
        p = self._parameters
        if self._pictures % p.renew_pictures == 0:
            self._samples = [*self._samples[-(p.samples - 1) :], levels]
            self._middle, self._noise = median_and_noise(np.stack(self._samples, axis=-1), p.levels_per_noise)
        self._pictures += 1
        foreground = np.abs(levels - self._middle) > p.threshold * self._noise
        return foreground.astype(np.uint8), self._middle


@register(
    "harbour_median",
    role="baseline",
    summary="temporal median of 14-bit counts, slowly renewed, blobs linked",
    suites=("harbour",),
)
class HarbourMedian(_Foreground):
    """The plainest background: what each pixel showed most of the time. Reads the counts.

    With a threshold of 4 it found no more and raised more alarms than with 5 on the development seeds.
    """

    name = "harbour_median"
    Parameters = MedianParameters
    _parameters: MedianParameters

    def _subtractor(self, samples: Sequence[Picture]) -> Subtractor:
        return _Median(self._parameters, samples)
