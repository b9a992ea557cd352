"""The state of one episode in a pictureless env, as a plain record."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from scenarios.command_link import LINK_FIELDS, LinkLimits
from trackers.kernels.records import record_kernel
from trackers.types import CameraModel, EgoPose, SteeredCamera

LATENTS = 8
ALONG, ACROSS, SPREAD, DENSEST_ALONG, DENSEST_ACROSS, DENSEST_SHARE, PROBABILITY, LENGTH = range(LATENTS)
"""The random quantities of a tracker's answer, in the order of ``EPISODE_STATE``'s ``latent``."""

NO_OTHER, OTHER_UNKNOWN = -1, -2
"""Instead of another object's index: no other object is in sight; the scene does not model other objects."""

_ANSWER: list[Any] = [
    ("known", "f8"),
    ("estimate_px", "f8", (2,)),
    ("depth_m", "f8"),
    ("probability", "f8"),
    ("length_share", "f8"),
    ("spread_m", "f8"),
    ("densest_offset_m", "f8", (2,)),
    ("densest_share", "f8"),
]
ANSWER = np.dtype(_ANSWER, align=True)
"""A tracker's answer in the picture that it watches; the fields are those of ``SIGHTING``, relative to its place."""

_FIELDS: list[Any] = [
    # Index of the bank's episode, and its frame.
    ("episode", "i8"),
    ("frame", "i8"),
    *LINK_FIELDS,
    # The carrier.
    ("place_m", "f8", (3,)),
    ("yaw_rad", "f8"),
    ("yaw_rate_rad_s", "f8"),
    # R_world_camera and the camera's place, true and as measured.
    ("R", "f8", (3, 3)),
    ("camera_m", "f8", (3,)),
    ("R_measured", "f8", (3, 3)),
    ("camera_measured_m", "f8", (3,)),
    # The target's truth; the place is that of its underside.
    ("target_m", "f8", (3,)),
    ("target_rad", "f8"),
    ("target_px", "f8", (2,)),
    ("length_px", "f8"),
    ("visible", "f8"),
    ("centring", "f8"),
    ("in_view", "f8"),
    ("frames_out", "i8"),
    # The tracker's mode, see ``error_kernel``.
    ("condition", "i8"),
    ("condition_frames", "i8"),
    ("mode", "i8"),
    ("unsure_frames", "i8"),
    # The object that the tracker confuses, or would confuse, with its target: index, and place relative to the target.
    ("other", "i8"),
    ("other_offset_m", "f8", (2,)),
    ("axis_rad", "f8"),
    ("latent", "f8", (LATENTS,)),
    *_ANSWER,
    # Distance of its place from the target's centre in the picture.
    ("error_px", "f8"),
]


def state_dtype(*fields: Any) -> np.dtype[Any]:
    """Return the record's dtype with a carrier's own ``fields``.

    They come first: Numba would treat a record that begins like another as a subtype of it, and would use a kernel
    compiled for one on the other.
    """
    return np.dtype([*fields, *_FIELDS], align=True)


EPISODE_STATE = state_dtype()


class KernelWorld:
    """Simulates B episodes at a time without pictures; their states (B,) are records of ``state_dtype``.

    A scene supplies the kernels and their data.

    Attributes:
        state_dtype: see ``state_dtype``.
        camera: that is steered, see ``camera_numbers``; of a head at zoom 1. interval_s: between frames.
        begin_kernel: called with the arguments of ``begin``, the data before the sightings.
        move_kernel: called with the arguments of ``move``, link and data before the sightings.
    """

    state_dtype: np.dtype[Any]
    begin_kernel: Any
    move_kernel: Any

    def __init__(self, data: Any, link: LinkLimits) -> None:
        """``data`` is a named tuple of all that the kernels read, with ``camera`` and ``interval_s``."""
        self.camera: NDArray[np.float64] = data.camera
        self.interval_s: float = data.interval_s
        self._data, self._link = data, link

    def cameras(self, state: Any) -> tuple[SteeredCamera, SteeredCamera | None]:
        """Return the camera that the tracker watches in a state, and the steered one if that is another."""
        return measured_camera(self.camera, state["R_measured"], state["camera_measured_m"]), None

    def begin(self, states: Any, which: Any, episodes: Any, at_frame_outs: bool, sightings: Any, rng: Any) -> None:
        """Begin ``episodes`` (K,) of the bank in the rows ``which`` (K,) of ``states``; write their first sightings."""
        self.begin_kernel(states, which, episodes, at_frame_outs, self._data, sightings, rng)

    def move(self, states: Any, wanted: Any, waiting: Any, sightings: Any, rng: Any) -> None:
        """Advance all episodes by a frame under the commands ``wanted`` (B, 4); ``waiting`` (B, D, 4) are delayed."""
        self.move_kernel(states, wanted, waiting, self._link, self._data, sightings, rng)


def measured_camera(camera: NDArray[np.float64], R: NDArray[np.float64], place_m: NDArray[np.float64]) -> SteeredCamera:
    """Return a camera, ``camera_numbers`` (3,), with its measured orientation R_world_camera (3, 3) and place (3,)."""
    T_world_camera = np.eye(4)
    T_world_camera[:3, :3], T_world_camera[:3, 3] = R, place_m
    width_px, height_px = (2 * camera[1:]).round().astype(int).tolist()
    return SteeredCamera(CameraModel(width_px, height_px, float(camera[0])), EgoPose(T_world_camera))


LEAD_FRAMES = (20, 40)
"""Range of the time before a likely loss: within it the belief, which starts without motion, learns it from the
tracker's answers."""


@record_kernel()
def begin_state(state: Any, episode: int, onsets: Any, before_onset: bool, rng: np.random.Generator) -> int:
    """Set a state to frame 0 of an episode, or to a frame before one of its ``onsets`` (N,); return the frame."""
    frame = frame_before(onsets, rng) if before_onset else 0
    state.episode, state.frame, state.steps, state.frames_out = episode, frame, 0, 0
    return frame


@record_kernel()
def frame_before(onsets: Any, rng: np.random.Generator) -> int:
    """Draw one of the frames ``onsets`` (N,), -1 for none, and return a frame 20 to 40 frames earlier, at least 0."""
    count = 0
    for k in range(len(onsets)):
        count += onsets[k] >= 0.0
    onset = int(onsets[int(rng.random() * count)]) if count > 0 else 0
    lead = LEAD_FRAMES[0] + int(rng.random() * (LEAD_FRAMES[1] - LEAD_FRAMES[0]))
    return max(onset - lead, 0)
