"""Experiments that measure a camera on a sheet of paper, without a tracker."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterator, Mapping
from contextlib import closing
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from benchmarks.contract.judging import truth_as
from benchmarks.contract.metric import Metric
from benchmarks.contract.rows import BlockKey, Row, rounded
from benchmarks.papers.experiment import PaperExperiment
from benchmarks.run.editions import Editions, package_versions, preset_edition
from benchmarks.run.experiment import Progress
from benchmarks.run.result_folder import MadeNow, append_block, make_folder, tidy, up_to_date
from benchmarks.run.workers import in_processes
from benchmarks.show.video import marks
from scenarios.paper_sheet.scenario import PAPER_SHEET
from scenarios.paper_sheet.sheet import region_of_sheet
from scenarios.scenario import RendererName
from scenarios.stereo_follow.truth import StereoTruth
from trackers.types import CameraRegisters

Values = Mapping[str, float | list[float]]
_TRACKER = "none"
_REGION_RGB = (230, 60, 60)


@dataclass(frozen=True, slots=True, kw_only=True)
class CameraExperiment(PaperExperiment):
    """See ``PaperExperiment``. Claims are about means of rows over seeds.

    Attributes:
        edition: of what is measured; raise it when that changes, see ``benchmarks.run.editions``.
    """

    suite: str = "paper"
    scenario: str = PAPER_SHEET.id
    edition: int = 1

    @property
    def methods(self) -> tuple[str, ...]:
        """See ``PaperExperiment``: rows of a camera have one that is no tracker."""
        return (_TRACKER,)

    @abstractmethod
    def measure(self, seed: int, renderer: RendererName) -> Values:
        """Return the values of one episode's rows; the last is the number of frames."""

    def metric(self, name: str) -> Metric:
        """See ``PaperExperiment``."""
        return Metric(name, "", "1", "higher")

    def run(self, out: Path, seeds: range, renderer: RendererName, workers: int, progress: Progress) -> list[str]:
        """See ``PaperExperiment``."""
        make_folder(out)
        have, moved = up_to_date(out, self.made_now(renderer), seeds)
        missing = [seed for seed in seeds if self._key(seed, renderer) not in have]
        progress(len(seeds) - len(missing), len(seeds))
        blocks = in_processes(partial(self.block, renderer=renderer), missing, workers)
        for done, block in enumerate(blocks, start=len(seeds) - len(missing) + 1):
            append_block(out, block)
            progress(done, len(seeds))
        return [*moved, *filter(None, [tidy(out)])]

    def made_now(self, renderer: RendererName) -> MadeNow:
        """See ``PaperExperiment``."""
        return lambda key: self._editions(renderer) if key == self._key(key.seed, renderer) else None

    def block(self, seed: int, renderer: RendererName) -> list[Row]:
        """Return the rows of one seed."""
        heading: Row = {
            "suite": self.suite,
            "scenario": self.scenario,
            "preset": self.preset,
            "tracker": _TRACKER,
            "role": "measured",
            "controller": None,
            "renderer": renderer,
            "seed": seed,
            "repeat": 0,
        }
        ending = {"weight": 1.0, "frame_out": None, "seconds": None, "editions": self._editions(renderer)}
        return [
            {**heading, "metric": name, "value": rounded(value), **ending}
            for name, value in self.measure(seed, renderer).items()
        ]

    def _editions(self, renderer: str) -> Editions:
        scene = preset_edition(self.scenario, self.preset)
        return {**package_versions(renderer), "scene": scene, "judge": f"{self.name} {self.edition}"}

    def _key(self, seed: int, renderer: str) -> BlockKey:
        return BlockKey(self.suite, self.scenario, self.preset, renderer, "", _TRACKER, seed)


@dataclass(frozen=True, slots=True)
class SheetPicture:
    """One picture of the sheet, by the left camera.

    Attributes:
        image_rgb: (H, W, 3) uint8.
        registers: the camera's settings.
        region_xyxy: (4,) measured rectangle within the sheet, pixels.
        illuminance_lx: mean on the sheet.
    """

    image_rgb: NDArray[np.uint8]
    registers: CameraRegisters
    region_xyxy: NDArray[np.float64]
    illuminance_lx: float

    @property
    def marked_rgb(self) -> NDArray[np.uint8]:
        """The picture with the rectangle drawn in."""
        marked = self.image_rgb.copy()
        marks.draw_box(marked, self.region_xyxy, _REGION_RGB)
        return marked


def photograph(
    preset: str, seed: int, renderer: RendererName = "raster", *, exposure: bool = False, white_balance: bool = False
) -> Iterator[SheetPicture]:
    """Yield the pictures of an episode.

    Args:
        exposure, white_balance: whether these stay as on the first picture.
    """
    with closing(PAPER_SHEET.episode(preset, seed, renderer=renderer)) as episode:
        for _ in range(episode.frame_count):
            frame = episode.step()
            episode.hold(exposure=exposure, white_balance=white_balance)
            truth = truth_as(frame.truth, StereoTruth)
            region_xyxy = region_of_sheet(frame.camera, truth.T_world_camera, truth.T_world_object[0])
            lux = float(truth.illuminance_lx[0])
            yield SheetPicture(frame.observation.image_rgb, truth.registers, region_xyxy, lux)
