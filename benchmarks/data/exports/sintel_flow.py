"""Optical flow in the folders of MPI Sintel and the .flo files of Middlebury.

Butler et al., A naturalistic open source movie for optical flow evaluation, ECCV 2012, http://sintel.is.tue.mpg.de.
Baker et al., A database and evaluation methodology for optical flow, IJCV 2011, https://vision.middlebury.edu/flow.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from benchmarks.data.exports.exporter import Exporter, export_format
from benchmarks.data.sets.channels import CODINGS
from benchmarks.data.sets.forward_flow import forward_flow
from benchmarks.data.sets.stored_episode import StoredEpisode

TAG, UNKNOWN = 202021.25, 1e10
"""What a .flo file begins with, and what stands for no flow."""


@export_format("sintel-flow")
class SintelFlow(Exporter):
    """Pictures with forward optical flow and occlusions.

    Format: MPI Sintel, http://sintel.is.tue.mpg.de (Butler et al., ECCV 2012), as readers of it (RAFT, torchvision)
    expect it. Each episode is a scene `SCENE`: `training/clean/SCENE/frame_NNNN` are its pictures, from 1 on,
    `training/flow/SCENE/frame_NNNN.flo` the flow of each but the last one to the next picture, as Middlebury writes it:
    "PIEH", width, height, and x (right) and y (down) of each pixel, row by row, as 32-bit numbers; above 1e9 where
    there is none: sky, what the next camera has behind it, and people and cyclists who pass by.

    The flow is exact, computed from depth and poses, also of points that the next picture does not show. There
    `training/occlusions/SCENE/frame_NNNN.png` is 255, else 0: it is hidden or outside then; seen is what one of the
    four pixels about its place shows, the same body at a depth within 1 %. `training/invalid/…` is 255 where there is
    no flow.
    """

    channels = ("image_rgb", "depth_m", "instance_map")

    def write_episode(self, episode: StoredEpisode) -> None:
        """Write pictures, flow and occlusions."""
        scene = self.name_of(episode)
        for stored in self.frames(episode):
            name = f"{scene}/frame_{stored.index + 1:04d}"
            self.write_picture(stored, f"training/clean/{name}")
            if stored.index + 1 < len(episode):
                flow_px, seen_next = forward_flow(episode, stored.index)
                known = np.isfinite(flow_px[..., 0])
                self.place(f"training/flow/{name}.flo").write_bytes(flo(flow_px))
                for folder, mask in (("occlusions", known & ~seen_next), ("invalid", ~known)):
                    content = CODINGS["png"].encode(np.where(mask, 255, 0).astype(np.uint8))
                    self.place(f"training/{folder}/{name}.png").write_bytes(content)


def flo(flow_px: NDArray[np.float32]) -> bytes:
    """Return a flow (H, W, 2) as a file of Middlebury."""
    height, width = flow_px.shape[:2]
    values = np.where(np.isfinite(flow_px), flow_px, UNKNOWN).astype("<f4")
    return np.array([TAG], "<f4").tobytes() + np.array([width, height], "<i4").tobytes() + values.tobytes()
