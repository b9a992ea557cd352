"""Pictureless scenes with a steered head beside a camera at rest, which the tracker watches: the arrays of a plan."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from scenarios import catalog
from scenarios.envs.pictureless.poses import camera_numbers
from scenarios.scenario import Pictureless, Setup
from scenarios.stage import Planned

_MOST_OTHERS, _MOST_ONSETS = 16, 16
_FAR_AWAY_M = 1e6
_CLOSE_LENGTHS = 2.0
"""A loss is likely if another object comes as near to the target, in its longest side, or hides half of it."""
_HIDDEN = 0.5


class HeadPictureless(Pictureless):
    """See ``scenarios.scenario.Pictureless``.

    What the tracker watches does not depend on commands, so that a plan has the target's visible share too, of the
    surfaces that its picture would show.

    Attributes:
        scenario: catalogue id.
    """

    scenario: str
    world_place = "scenarios.envs.pictureless.head_world:HeadWorld"
    watches_at_rest = True

    def is_playable(self, preset: Any) -> bool:
        """Return True: the poses of both cameras are always measured."""
        return True

    def arrays(self, preset: Any, seed: int) -> dict[str, NDArray[np.float64]]:
        """Return all paths, where the head's camera sees the target, both cameras, and the head.

        ``target_m`` (T, 3) of the target's underside, ``target_rad`` (T,), ``size_m`` (3,); ``seen_m`` (T, 3) the same
        place as the head's camera sees it, e.g. through water; ``hidden`` (T,) share that the watched camera does not
        see; ``others_m`` (T, 16, 2) of other objects, absent ones far away; ``onsets`` (16,) frames on which a loss
        becomes likely, -1 for none. Of the watched camera ``watched`` (3,) focal length, half width, half height in
        pixels, ``watched_pose`` (3, 4), and ``surveyed_pose`` (3, 4) as measured; of the head ``lens`` (3,) likewise
        at zoom 1, ``place_m`` (3,) and ``measured_m`` (3,), ``axes`` (3, 3): rows ahead at pan and tilt 0, left, up,
        and ``first``, ``lowest``, ``highest`` (3,) pan, tilt and zoom.
        """
        scenario = catalog.scenario(self.scenario)
        plan = scenario.stage(Setup(scenario, preset, seed, closed_loop=True, covers_all=False)).planned()
        poses, k = plan.T_world_object, plan.target
        target_m, others_m = poses[:, k, :3, 3], _others_m(plan)
        hidden = 1.0 - plan.visible_fraction
        near_m = np.linalg.norm(others_m - target_m[:, None, :2], axis=-1).min(axis=1, initial=_FAR_AWAY_M)
        mount, head = plan.head.mount, plan.head
        return {
            "target_m": target_m,
            "target_rad": np.arctan2(poses[:, k, 1, 0], poses[:, k, 0, 0]),
            "size_m": plan.size_m[k],
            "seen_m": _seen_m(plan),
            "hidden": hidden,
            "others_m": others_m,
            "onsets": _onsets((near_m < _CLOSE_LENGTHS * plan.size_m[k].max()) | (hidden > _HIDDEN)),
            "watched": camera_numbers(plan.camera),
            "watched_pose": plan.T_world_camera[:3],
            "surveyed_pose": plan.ego.T_world_camera[:3],
            "lens": camera_numbers(mount.lens),
            "place_m": np.array(mount.place_m),
            "measured_m": plan.head_ego.T_world_camera[:3, 3],
            "axes": head.axes,
            "first": np.array([head.pan_rad, head.tilt_rad, head.zoom]),
            "lowest": np.array([-mount.widest_pan_rad, mount.tilt_rad[0], mount.zoom[0]]),
            "highest": np.array([mount.widest_pan_rad, mount.tilt_rad[1], mount.zoom[1]]),
        }


def _others_m(plan: Planned) -> NDArray[np.float64]:
    """Return the places (T, 16, 2) of other objects over the ground."""
    others = [n for n in range(len(plan.size_m)) if n != plan.target][:_MOST_OTHERS]
    places_m = np.full((len(plan.present), _MOST_OTHERS, 2), _FAR_AWAY_M)
    for slot, n in enumerate(others):
        here = plan.present[:, n]
        places_m[here, slot] = plan.T_world_object[here, n, :2, 3]
    return places_m


def _seen_m(plan: Planned) -> NDArray[np.float64]:
    """Return where the head's camera sees the target's underside (T, 3), at its true distance along the axis."""
    T, camera = plan.head.T_world_camera, plan.head.camera
    pose, half_m = plan.T_world_object[:, plan.target], 0.5 * plan.size_m[plan.target, 2]
    depth_m = (pose[:, :3, 3] + half_m * pose[:, :3, 2] - T[:3, 3]) @ T[:3, 2]
    tangents = (plan.head_px - camera.centre_px) / camera.focal_px
    rays = np.column_stack([tangents, np.ones(len(tangents))]) @ T[:3, :3].T
    return np.asarray(T[:3, 3] + depth_m[:, None] * rays - [0.0, 0.0, half_m])


def _onsets(likely: NDArray[np.bool_]) -> NDArray[np.float64]:
    """Return the frames (16,) on which a loss becomes likely, of frames (T,) on which it is."""
    begins = np.flatnonzero(np.diff(likely.astype(int)) > 0)
    # A start near the end would leave too short an episode.
    begins = begins[begins < 0.85 * len(likely)][:_MOST_ONSETS]
    onsets = np.full(_MOST_ONSETS, -1.0)
    onsets[: len(begins)] = begins
    return onsets
