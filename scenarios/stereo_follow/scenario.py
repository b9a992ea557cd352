"""The scenario ``stereo-follow-v1``: a person among others, followed by a robot with a stereo camera."""

from __future__ import annotations

from dataclasses import dataclass, field

from scenarios.scenario import RendererName
from scenarios.stereo_follow.episode import StereoFollowEpisode
from scenarios.stereo_follow.plan import make_plan
from scenarios.stereo_follow.presets import PRESETS, StereoFollow
from sim.rng import episode_seed


@dataclass(frozen=True)
class StereoFollowScenario:
    """See ``scenarios.scenario.Scenario``."""

    id: str = "stereo-follow-v1"
    summary: str = "a person among others, followed by a robot with a stereo camera from corridor to yard"
    start: str = "the first pair and the person's box in the left picture; the camera's settings; odometry"
    presets: dict[str, StereoFollow] = field(default_factory=lambda: dict(PRESETS))

    def configuration(self, preset: str) -> StereoFollow:
        """Return a preset by name.

        Raises:
            ValueError: for an unknown name; lists the known ones.
        """
        if preset not in self.presets:
            raise ValueError(f"preset: expected one of {', '.join(self.presets)}; got {preset!r}")
        return self.presets[preset]

    def episode(
        self,
        preset: str,
        seed: int,
        *,
        renderer: RendererName = "raster",
        closed_loop: bool | None = None,
    ) -> StereoFollowEpisode:
        """Build one episode.

        Args:
            seed: any whole number >= 0; 10,000 to 19,999 is the test split.
            closed_loop: whether commands drive the robot; None = as the preset says.

        Raises:
            ValueError: for an unknown preset or renderer, or a negative seed.
        """
        configuration = self.configuration(preset)
        looped = configuration.closed_loop if closed_loop is None else closed_loop
        plan = make_plan(configuration, episode_seed(seed, self.id, 0), closed_loop=looped)
        return StereoFollowEpisode(plan, renderer)


STEREO_FOLLOW = StereoFollowScenario()
