"""Play of an env by keyboard: a person steers by the picture and is scored like a controller."""

from __future__ import annotations

import itertools
import sys
import time
import warnings
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import cv2
import gymnasium as gym
import numpy as np
from numpy.typing import NDArray

from benchmarks.contract.judging import Ending, Judge, ScoreSheet
from benchmarks.contract.rows import HUMAN
from benchmarks.contract.suite import controllers_suite
from benchmarks.run.episodes import Steering, editions_of, simulated
from benchmarks.run.jobs import Job, block_of, heading_of, take_in
from benchmarks.run.result_folder import append_block
from benchmarks.run.selection import tracker_named
from benchmarks.show.video.drawing import draw_steered
from scenarios import catalog
from scenarios.envs.follow_env import FollowEnv
from scenarios.envs.view import open_display
from trackers.types import BODY_COMMANDS, Carrier

_KEYS = {
    "forward_mps": ("w", "s"),
    "right_mps": ("d", "a"),
    "climb_mps": ("r", "f"),
    "yaw_rate_rad_s": ("q", "e"),
    "pan_rad_s": ("j", "l"),
    "tilt_rad_s": ("i", "k"),
    "zoom_per_s": ("u", "o"),
}
"""Number of a command -> key that raises it, key that lowers it."""
_TURNS_BY_SIDE = ("a", "d")
"""Keys that turn a carrier that moves as a whole, without sideways motion."""
_SHARE_OF_A_HEAD = 0.25
"""Of a head's limits that a key commands: at all of it a narrow view is past the target within a frame or two."""
_ESTIMATE_RGB = (230, 159, 0)
_INSTALL = "pip install 'frameout[play]'"


class _AllPlayed(Exception):
    """No episode is left."""


@dataclass(frozen=True)
class Play:
    """Settings of a play.

    Attributes:
        env: env id. preset, tracker, link: see ``FollowSettings``.
        seeds: of the episodes.
        out: folder for the rows.
        zoom: of the picture on the screen. modules: users' own modules, which the rows name.
    """

    env: str
    preset: str
    tracker: str
    link: str
    seeds: range
    out: Path
    zoom: float = 1.0
    modules: tuple[str, ...] = ()


def check_screen() -> None:
    """Raise ValueError if pygame or a screen is missing."""
    _pygame_play()
    open_display("display")


def play(played: Play) -> int:
    """Open a window and play the episodes; return how many were played to their end with a key pressed.

    Raises:
        ValueError: see ``check_screen``.
    """
    check_screen()
    pygame_play = _pygame_play()
    env = gym.make(
        f"scenarios:{played.env}",
        preset=played.preset,
        tracker=played.tracker,
        link=played.link,
        render_mode="rgb_array",
        disable_env_checker=True,
    )
    recorded = _Recorded(env, played)
    keys = {word: shares.astype(np.float32) for word, shares in key_combinations(recorded.carrier)}
    try:
        noop = np.zeros(env.action_space.shape or (), np.float32)
        pygame_play(recorded, fps=env.metadata["render_fps"], zoom=played.zoom, keys_to_action=keys, noop=noop)
    except _AllPlayed:
        pass
    finally:
        recorded.close()
        _quit_pygame()
    return recorded.finished


def key_combinations(carrier: Carrier) -> Iterator[tuple[str, NDArray[np.float64]]]:
    """Yield keys held together and their action (A,), each number 0 or a share of the limit with a sign."""
    names = [axis.name for axis in carrier.axes]
    pairs = [_KEYS[name] for name in names]
    if "yaw_rate_rad_s" in names and "right_mps" not in names:
        pairs[names.index("yaw_rate_rad_s")] = _TURNS_BY_SIDE
    shares = np.array([1.0 if name in BODY_COMMANDS else _SHARE_OF_A_HEAD for name in names])
    for signs in itertools.product((0, 1, -1), repeat=len(names)):
        word = "".join(pair[0 if sign > 0 else 1] for pair, sign in zip(pairs, signs, strict=True) if sign)
        if word:
            yield word, shares * np.array(signs)


class _Recorded(gym.Wrapper[Any, Any, Any, Any]):
    """Plays one seed after the other and writes rows of every steered episode that ends.

    Attributes:
        finished: number of episodes with written rows.
    """

    def __init__(self, env: gym.Env[Any, Any], played: Play) -> None:
        super().__init__(env)
        unwrapped = env.unwrapped
        assert isinstance(unwrapped, FollowEnv)
        self._follow = unwrapped
        self.carrier = unwrapped.carrier
        self.finished = 0
        self._played, self._left = played, list(played.seeds)
        self._judge: Judge | None = None
        self._sheet: ScoreSheet | None = None
        self._started = 0.0
        self._steered = False

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> Any:
        """Begin the next seed's episode."""
        if not self._left:
            raise _AllPlayed
        result = self.env.reset(seed=seed, options={"episode_seed": self._left[0]})
        self._started, self._steered = time.perf_counter(), False
        scenario = catalog.scenario(self._follow.settings.scenario)
        self._judge = controllers_suite().judge(self._follow.episode.episode, scenario)
        self._sheet = self._judge.sheet()
        take_in(self._follow.episode, self._judge, [self._sheet])
        return result

    def step(self, action: Any) -> Any:
        """Step, and pass the frame to the judge."""
        result = self.env.step(action)
        self._steered = self._steered or bool(np.any(action))
        assert self._judge is not None
        assert self._sheet is not None
        take_in(self._follow.episode, self._judge, [self._sheet])
        if result[2] or result[3]:
            # Only now: an episode may be reset more than once before it is played.
            seed = self._left.pop(0)
            if self._steered:
                self._write(seed)
            else:
                print(f"note: episode {seed} is not scored: no key was pressed", file=sys.stderr)
        return result

    def render(self) -> Any:
        """Return the picture (H, W, 3) that the tracker gets, with its estimate, and what a second camera looks at."""
        episode = self._follow.episode
        picture = episode.frame.observation.image_rgb.copy()
        draw_steered(picture, episode.frame, 1.0)
        place = np.asarray(episode.estimate.position_px, dtype=float)
        if np.isfinite(place).all() and (np.abs(place) < 1e5).all():
            cv2.drawMarker(picture, [int(v) for v in np.rint(place)], _ESTIMATE_RGB, cv2.MARKER_CROSS, 15, 2)
        return picture

    def _write(self, seed: int) -> None:
        episode, played = self._follow.episode, self._played
        settings = self._follow.settings
        suite = controllers_suite()
        watched = simulated(settings.scenario, played.preset, seed, renderer=settings.renderer)
        made = editions_of(suite, watched, tracker := tracker_named(played.tracker))
        steering = Steering(HUMAN, watched.scenario.carrier.name, played.link)
        job = Job(suite, replace(watched, steering=steering), {played.tracker: tracker}, played.modules)
        ending = {"seconds": round(time.perf_counter() - self._started, 3), "editions": made}
        heading = heading_of(job, played.tracker, controller_role="external")
        assert self._sheet is not None
        scores = [(0, score) for score in self._sheet.scores(Ending())]
        append_block(played.out, block_of(suite, heading, scores, episode.frame.truth.frame + 1, ending))
        self.finished += 1


def _pygame_play() -> Any:
    """Return Gymnasium's ``play``. Raises ValueError without pygame."""
    try:
        with warnings.catch_warnings():
            # It warns without Tk, which only its unused curves need.
            warnings.simplefilter("ignore")
            from gymnasium.utils.play import play as gymnasium_play
    except gym.error.DependencyNotInstalled:
        raise ValueError(f"play: expected pygame to be installed ({_INSTALL}), got none") from None
    return gymnasium_play


def _quit_pygame() -> None:
    import pygame

    pygame.quit()
