"""``opencv_csrt``: CSRT of OpenCV's contrib modules, in a process with an environment of its own.

The contrib wheel cannot stand beside the plain one. This makes the environment, once::

    python -m trackers.clients opencv_contrib.py

Other trackers of these modules run by ``frameout bench --process NAME="opencv_contrib.py KCF"``.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from trackers.clients.environments import environment_of, made_environment
from trackers.clients.remote import PORTABLE, Program, RemoteTracker, remote_tracker
from trackers.kernels.boxes import box_size
from trackers.registry import NoParameters, register
from trackers.types import Estimate, Observation

ADAPTER = PORTABLE / "opencv_contrib.py"


def missing_contrib() -> str:
    """Return how to make the environment if there is none, else ""."""
    if environment_of(ADAPTER).is_file():
        return ""
    return f"its environment; make it by: python -m trackers.clients {ADAPTER.name}"


@register(
    "opencv_csrt",
    role="baseline",
    summary="OpenCV's CSRT, a general tracker; needs an environment of its own (see its docstring)",
    suites=("frame-out", "stereo"),
    missing=missing_contrib,
)
class OpenCvCsrt:
    """``cv2.TrackerCSRT``, see ``trackers/clients/portable/opencv_contrib.py``.

    It takes part in default runs where its environment exists; named without one, it fails with how to make it.
    """

    Parameters = NoParameters

    def __init__(self, parameters: NoParameters, rng: np.random.Generator) -> None:
        if missing := missing_contrib():
            raise RuntimeError(f"opencv_csrt: expected {missing}")
        program = Program((str(made_environment(ADAPTER)), str(ADAPTER), "CSRT"))
        tracker = remote_tracker(program, {}, rng)
        assert isinstance(tracker, RemoteTracker)
        self._tracker = tracker

    @property
    def elsewhere_cpu_s(self) -> float:
        """See ``OutsourcingTracker``."""
        return self._tracker.elsewhere_cpu_s

    def initialise(self, observation: Observation, box_xyxy: NDArray[np.float64]) -> None:
        """See ``Tracker``."""
        box_size(box_xyxy)
        self._tracker.initialise(observation, box_xyxy)

    def update(self, observation: Observation) -> Estimate:
        """See ``Tracker``."""
        return self._tracker.update(observation)
