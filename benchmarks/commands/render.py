"""``frameout render``: write an episode as a video."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro

from benchmarks.commands.arguments import COUNT, FILE, ONE_NAME
from benchmarks.run.experiment import check_renderer
from benchmarks.video.episode_video import render_episode
from scenarios import catalog


@dataclass(frozen=True)
class Render:
    """Write one episode as an MP4: the camera's picture, the truth, and a tracker's estimate.

    A road town is shown in a larger view; a followed person with both pictures, disparity and a view from above.

    Attributes:
        scenario: catalogue id, see `frameout list`; without a version the latest.
        preset: one of the scenario's.
        seed: of the episode, a whole number >= 0.
        tracker: name of the tracker to draw (default: truth only).
        controller: name of the controller that steers by the tracker's estimate (default: a set path).
        renderer: raster or pybullet.
        frames: number of frames (default: the whole episode).
        scale: size of the larger view over that of the camera's picture, >= 1.
        out: the file (default: results/SCENARIO-PRESET-SEED.mp4).
    """

    scenario: Annotated[str, tyro.conf.Positional] = "road-town"
    preset: str = "standard"
    seed: int = 0
    tracker: Annotated[str | None, ONE_NAME] = None
    controller: Annotated[str | None, ONE_NAME] = None
    renderer: str = "raster"
    frames: Annotated[int | None, COUNT] = None
    scale: float = 2.0
    out: Annotated[Path | None, FILE] = None

    def run(self) -> int:
        """Write it; return the exit status."""
        scenario = catalog.scenario(self.scenario)
        if self.seed < 0:
            raise ValueError(f"seed: expected a whole number >= 0, got {self.seed}")
        name = f"{scenario.id}-{self.preset}-{self.seed}.mp4"
        path = render_episode(
            scenario.id,
            self.out or Path("results") / name,
            preset=self.preset,
            seed=self.seed,
            tracker=self.tracker,
            controller=self.controller,
            renderer=check_renderer(self.renderer),
            frames=self.frames,
            scale=self.scale,
        )
        print(path)
        return 0
