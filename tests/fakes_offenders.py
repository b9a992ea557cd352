"""Trackers that change what others get or are set to, and one that would feel it; importing it registers them."""

from __future__ import annotations

import ctypes
import os
import random
import warnings
from collections.abc import Callable

import cv2
import numpy as np

from tests.fakes_trackers import NoParameters, _Fake
from trackers.registry import register
from trackers.types import Estimate, Observation

STRIKES_AT = 5
"""Frame from which on the offenders strike."""


def _register(name: str, offence: Callable[[Observation], object]) -> None:
    @register(name, role="baseline", summary="an offender")
    class _Offender(_Fake):
        def misbehave(self, observation: Observation) -> Estimate:
            if self._frame >= STRIKES_AT:
                offence(observation)
            return super().misbehave(observation)


def _overwrite(array: np.ndarray) -> None:
    """Write past NumPy, as ``torch.from_numpy(array).bitwise_not_()`` does."""
    ctypes.memset(array.ctypes.data, 77, array.nbytes)


def _overwrite_pose(observation: Observation) -> None:
    assert observation.ego is not None
    _overwrite(observation.ego.T_world_camera)


def _set_all(observation: Observation) -> None:
    np.seterr(all="raise")
    os.chdir("/")
    np.random.seed(0)  # noqa: NPY002
    random.seed(0)
    warnings.simplefilter("ignore", ResourceWarning)
    cv2.setNumThreads(5)


CHANGES = {
    "offends_picture": ("observation.image_rgb", lambda seen: _overwrite(seen.image_rgb)),
    "offends_pose": ("observation.ego.T_world_camera", _overwrite_pose),
    "offends_camera": ("observation.camera.focal_px", lambda seen: object.__setattr__(seen.camera, "focal_px", 1.0)),
    "offends_time": ("observation.time_s", lambda seen: object.__setattr__(seen, "time_s", -1.0)),
}
"""Offender -> what it changes, and how."""
for _name, (_, _offence) in CHANGES.items():
    _register(_name, _offence)
_register("offends_settings", _set_all)


@register("fake_feels", role="baseline", summary="off its place by all that others might change")
class Feels(_Fake):
    """Seeds the global random numbers and draws from them, as much code does."""

    def __init__(self, parameters: NoParameters, rng: np.random.Generator) -> None:
        super().__init__(parameters, rng)
        np.random.seed(1)  # noqa: NPY002
        random.seed(1)

    def misbehave(self, observation: Observation) -> Estimate:
        assert observation.ego is not None
        ahead = [float(observation.image_rgb.max()), observation.time_s, observation.camera.focal_px]
        ahead += [*observation.ego.T_world_camera.ravel(), len(os.getcwd()), len(warnings.filters), cv2.getNumThreads()]
        ahead += [np.random.rand(), random.random(), sum(map(len, np.geterr().values()))]  # noqa: NPY002
        return Estimate(self._centre + np.array(ahead) @ np.ones((len(ahead), 2)), self._box)
