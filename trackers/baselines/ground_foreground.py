"""``harbour_mog2``, ``harbour_knn`` and ``harbour_median``: what differs from a background, standing on the ground.

What an engineer would try first on a thermal camera at rest: a background subtractor, morphology, blobs projected onto
the ground plane z = 0 by the camera's calibration, and one linker for all three.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Protocol

import cv2
import numpy as np
from numpy.typing import NDArray

from trackers.baselines.ground_blobs import BlobParameters, blobs_of
from trackers.baselines.ground_linker import EVIDENCE, GroundLinker, LinkParameters, learnt_weights
from trackers.registry import register, tunable
from trackers.site.survey import Site, survey
from trackers.site.volume import WatchedVolume
from trackers.types import CameraModel, Observation, Track

Grey = NDArray[np.uint8]

_LEAST_NOISE = 1.0
"""Grey levels; rounding and the camera's noise."""
_NORMAL_MAD = 1.4826
_NOISE_SAMPLES = 60


class Subtractor(Protocol):
    """A method of background subtraction."""

    def apply(self, grey: Grey) -> tuple[NDArray[np.uint8], NDArray[np.uint8]]:
        """Take in a picture (H, W); return its foreground (H, W), not 0 where something is, and the background."""
        ...


@dataclass(frozen=True)
class ForegroundParameters(BlobParameters, LinkParameters):
    """Parameters that the three baselines share.

    Attributes:
        volume: that is watched.
    """

    volume: WatchedVolume = field(default_factory=WatchedVolume)


class _Foreground:
    """A ``MultiTracker`` of what a subtractor takes for foreground.

    The contrast of a blob is measured in the noise of each pixel: the median absolute deviation over the pictures of
    the background. It ranks the answers and finds nothing.

    Attributes:
        name: under which its confidences are stored.
        decides_at: see ``DecidingTracker``. Confidences are those of as many intruders as others.
    """

    name: str
    decides_at = 0.5

    def __init__(self, parameters: ForegroundParameters, rng: np.random.Generator) -> None:
        self._parameters, self._rng = parameters, rng
        self._begin((), None)

    def _subtractor(self, samples: Sequence[Grey]) -> Subtractor:
        """Return the method, which has learnt from pictures of the background, possibly none."""
        raise NotImplementedError

    def start(self, background: Sequence[Observation], camera: CameraModel) -> None:
        """See ``MultiTracker``."""
        size = (camera.height_px, camera.width_px)
        greys = [np.ascontiguousarray(each.image_rgb[..., 0]) for each in background]
        self._begin([grey for grey in greys if grey.shape == size], survey(self._parameters.volume, camera, background))

    @property
    def evidence(self) -> NDArray[np.float64]:
        """(N, 10) for the N tracks of the latest answer, see ``ground_linker.evidence_of``."""
        return np.empty((0, len(EVIDENCE))) if self._linker is None else self._linker.evidence

    def _begin(self, greys: Sequence[Grey], site: Site | None) -> None:
        self._method = self._subtractor(greys)
        self._noise = noise_of(greys) if greys else None
        self._size = greys[0].shape if greys else None
        self._site = site
        self._linker: GroundLinker | None = None

    def update(self, observation: Observation) -> list[Track]:
        """See ``MultiTracker``. A picture of another size than the first one learnt has no answer."""
        p, camera = self._parameters, observation.camera
        grey = np.ascontiguousarray(observation.image_rgb[..., 0])
        self._size = grey.shape if self._size is None else self._size
        if grey.shape != self._size:
            return []
        if self._site is None:
            self._site = survey(p.volume, camera, [observation])
        foreground, background = self._method.apply(grey)
        if self._site is None:
            return []
        if self._linker is None:
            self._linker = GroundLinker(p, self._site.view, learnt_weights(self.name))
        noise = _LEAST_NOISE if self._noise is None else self._noise
        contrast = cv2.absdiff(grey, background).astype(np.float32) / noise
        return self._linker.follow(blobs_of(foreground, contrast, self._site, p), observation.time_s)


def noise_of(greys: Sequence[Grey]) -> NDArray[np.float32]:
    """Return the noise (H, W) of each pixel over pictures (H, W): 1.48 times the median absolute deviation."""
    samples = np.stack([greys[k] for k in np.linspace(0, len(greys) - 1, _NOISE_SAMPLES).astype(int)], axis=-1)
    return median_and_noise(samples)[1]


def median_and_noise(samples: NDArray[np.uint8]) -> tuple[Grey, NDArray[np.float32]]:
    """Return the median (H, W) of samples (H, W, N), the upper one of two, and their robust standard deviation (H, W).

    The latter is 1.48 times the median absolute deviation, at least 1 grey level.
    """
    half = samples.shape[-1] // 2
    middle = np.partition(samples, half, axis=-1)[..., half]
    beside = middle[..., None]
    away = np.partition(np.maximum(samples, beside) - np.minimum(samples, beside), half, axis=-1)
    return middle, np.maximum(_NORMAL_MAD * away[..., half], _LEAST_NOISE).astype(np.float32)


class _OfOpenCV:
    """MOG2 or KNN, which learn from every picture."""

    def __init__(self, method: cv2.BackgroundSubtractor, samples: Sequence[Grey], rng: np.random.Generator) -> None:
        self._method, self._rng = method, rng
        for grey in samples:
            self._take_in(grey)

    def _take_in(self, grey: Grey) -> NDArray[np.uint8]:
        # KNN draws the samples that it renews from OpenCV's own generator, which all of a process share.
        cv2.setRNGSeed(int(self._rng.integers(1 << 31)))
        foreground: NDArray[np.uint8] = self._method.apply(grey)
        return foreground

    def apply(self, grey: Grey) -> tuple[NDArray[np.uint8], NDArray[np.uint8]]:
        return self._take_in(grey), self._method.getBackgroundImage()


@dataclass(frozen=True)
class Mog2Parameters(ForegroundParameters):
    """Parameters of ``harbour_mog2``; the values of OpenCV are 500 and 16.

    Attributes:
        history: pictures over which it learns.
        threshold: squared Mahalanobis distance of foreground.
    """

    history: int = tunable(500, 50, 3000, log=True)
    threshold: float = tunable(16.0, 4.0, 100.0, log=True)


@register("harbour_mog2", role="baseline", summary="OpenCV's MOG2, blobs on the ground, linked", suites=("harbour",))
class HarbourMog2(_Foreground):
    """Zivkovic, Improved adaptive Gaussian mixture model for background subtraction, ICPR 2004, as in OpenCV."""

    name = "harbour_mog2"
    Parameters = Mog2Parameters
    _parameters: Mog2Parameters

    def _subtractor(self, samples: Sequence[Grey]) -> Subtractor:
        p = self._parameters
        method = cv2.createBackgroundSubtractorMOG2(p.history, p.threshold, detectShadows=False)
        return _OfOpenCV(method, samples, self._rng)


@dataclass(frozen=True)
class KnnParameters(ForegroundParameters):
    """Parameters of ``harbour_knn``; the values of OpenCV are 500 and 400.

    Attributes:
        history: pictures over which it learns.
        threshold: squared distance in grey levels from which on a sample is not near.
    """

    history: int = tunable(500, 50, 3000, log=True)
    threshold: float = tunable(400.0, 40.0, 4000.0, log=True)


@register("harbour_knn", role="baseline", summary="OpenCV's KNN, blobs on the ground, linked", suites=("harbour",))
class HarbourKnn(_Foreground):
    """Zivkovic and van der Heijden, Efficient adaptive density estimation per image pixel, 2006, as in OpenCV."""

    name = "harbour_knn"
    Parameters = KnnParameters
    _parameters: KnnParameters

    def _subtractor(self, samples: Sequence[Grey]) -> Subtractor:
        p = self._parameters
        method = cv2.createBackgroundSubtractorKNN(p.history, p.threshold, detectShadows=False)
        return _OfOpenCV(method, samples, self._rng)


@dataclass(frozen=True)
class MedianParameters(ForegroundParameters):
    """Parameters of ``harbour_median``.

    Attributes:
        samples: pictures that the median is of.
        renew_pictures: after so many the oldest sample is replaced.
        threshold: noise, as a robust standard deviation of each pixel's samples, from which on it is foreground.
    """

    samples: int = tunable(60, 10, 120)
    renew_pictures: int = tunable(10, 1, 60)
    threshold: float = tunable(5.0, 2.0, 15.0, log=True)


class _Median:
    """The median of each pixel over samples that are slowly renewed, and its noise."""

    def __init__(self, parameters: MedianParameters, greys: Sequence[Grey]) -> None:
        self._parameters = parameters
        count = min(parameters.samples, len(greys))
        self._samples = [greys[k] for k in np.linspace(0, len(greys) - 1, count).astype(int)]
        self._pictures = 0
        if self._samples:
            self._learn()

    def _learn(self) -> None:
        self._middle, self._noise = median_and_noise(np.stack(self._samples, axis=-1))

    def apply(self, grey: Grey) -> tuple[NDArray[np.uint8], NDArray[np.uint8]]:
        p = self._parameters
        if not self._samples or self._pictures % p.renew_pictures == 0:
            self._samples = [*self._samples[-(p.samples - 1) :], grey]
            self._learn()
        self._pictures += 1
        foreground = cv2.absdiff(grey, self._middle) > p.threshold * self._noise
        return foreground.astype(np.uint8), self._middle


@register(
    "harbour_median",
    role="baseline",
    summary="temporal median, slowly renewed, blobs on the ground, linked",
    suites=("harbour",),
)
class HarbourMedian(_Foreground):
    """The plainest background: what each pixel showed most of the time."""

    name = "harbour_median"
    Parameters = MedianParameters
    _parameters: MedianParameters

    def _subtractor(self, samples: Sequence[Grey]) -> Subtractor:
        return _Median(self._parameters, samples)
