"""What paper B's experiments on the camera alone look at, picture by picture, in the episodes that they are about."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from benchmarks.papers.measured import SCENARIO
from benchmarks.suites.judging import told_by
from scenarios import catalog
from scenarios.paper_sheet.episode import SheetEpisode
from scenarios.paper_sheet.sheet import region_of_sheet
from scenarios.scenario import RendererName
from scenarios.stereo_follow.truth import PeopleTruth
from trackers.types import CameraRegisters


@dataclass(frozen=True, slots=True)
class SheetPicture:
    """One picture of the sheet, by the left camera.

    Attributes:
        image_rgb: (H, W, 3) uint8.
        registers: the camera's settings.
        region_xyxy: (4,) rectangle within the sheet whose colours are looked at, pixels.
        illuminance_lx: mean on the sheet.
    """

    image_rgb: NDArray[np.uint8]
    registers: CameraRegisters
    region_xyxy: NDArray[np.float64]
    illuminance_lx: float


def open_episode(preset: str, seed: int, renderer: RendererName) -> SheetEpisode:
    """Return an episode whose target is a sheet."""
    episode = catalog.scenario(SCENARIO).episode(preset, seed, renderer=renderer)
    assert isinstance(episode, SheetEpisode)
    return episode


def next_picture(episode: SheetEpisode) -> SheetPicture:
    """Live through the next frame."""
    frame = episode.step()
    truth = told_by(frame.truth, PeopleTruth)
    return SheetPicture(
        frame.observation.image_rgb,
        truth.registers,
        region_of_sheet(frame.camera, truth.T_world_camera, truth.T_world_object[0]),
        float(truth.illuminance_lx[0]),
    )
