"""Play of an env by keyboard: a person steers by the picture and is scored like a controller."""

from __future__ import annotations

import sys
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from benchmarks.contract.judging import Ending, ScoreSheet
from benchmarks.contract.rows import HUMAN
from benchmarks.contract.suite import controllers_suite
from benchmarks.run.episodes import Steering, editions_of, simulated
from benchmarks.run.jobs import Job, block_of, heading_of, take_in
from benchmarks.run.packages import check_packages
from benchmarks.run.result_folder import append_block
from benchmarks.run.selection import tracker_named
from benchmarks.show.video.drawing import Canvas, draw_steered
from scenarios.envs.follow_env import FollowEnv
from scenarios.envs.settings import FollowSettings
from scenarios.envs.view import Window, draw_place, open_display
from scenarios.loop import Loop
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


def check_screen() -> None:
    """Raise ValueError if pygame or a screen is missing."""
    check_packages(["pygame"], "play")
    open_display("display")


def play(settings: FollowSettings, seeds: range, out: Path, zoom: float = 1.0, modules: tuple[str, ...] = ()) -> int:
    """Open a window and play the episodes; return how many were played to their end with a key pressed.

    Args:
        settings: of the env; tracker and link by name.
        out: folder for the rows. zoom: of the picture on the screen. modules: users' own, which the rows name.

    Raises:
        ValueError: see ``check_screen``.
    """
    check_screen()
    env = FollowEnv(
        settings.scenario,
        preset=settings.preset_name,
        tracker=settings.tracker,
        link=settings.link,
        action="command",
        worlds=0,
    )
    window = Window(env.metadata["render_fps"])
    held: set[int] = set()
    finished = 0
    try:
        for seed in seeds:
            env.reset(options={"episode_seed": seed})
            loop, suite, started = env.episode, controllers_suite(), time.perf_counter()
            judge = suite.judge_of(loop.episode, simulated(settings.scenario, settings.preset_name, seed).scenario)
            sheet, steered = judge.sheet(), False
            take_in(loop, judge, [sheet])
            while not loop.is_over:
                window.show(_picture(loop, zoom))
                if not _read_keys(held):
                    return finished
                action = action_of(env.carrier, held)
                env.step(action)
                take_in(loop, judge, [sheet])
                steered = steered or bool(action.any())
            if steered:
                _write(settings, seed, loop, sheet, time.perf_counter() - started, out, modules)
                finished += 1
            else:
                print(f"note: episode {seed} is not scored: no key was pressed", file=sys.stderr)
    finally:
        env.close()
        window.close()
    return finished


def action_of(carrier: Carrier, held: set[int]) -> NDArray[np.float32]:
    """Return the action (A,) of the keys that are held down, each number 0 or a share of the limit with a sign."""
    names = [axis.name for axis in carrier.axes]
    action = np.zeros(len(names), np.float32)
    for k, name in enumerate(names):
        turns_by_side = name == "yaw_rate_rad_s" and "right_mps" not in names
        up, down = map(ord, _TURNS_BY_SIDE if turns_by_side else _KEYS[name])
        action[k] = ((up in held) - (down in held)) * (1.0 if name in BODY_COMMANDS else _SHARE_OF_A_HEAD)
    return action


def _read_keys(held: set[int]) -> bool:
    """Bring the keys that are held down up to date; return False if the window is closed, or Escape is pressed."""
    import pygame

    for event in pygame.event.get():
        if event.type == pygame.QUIT or (event.type == pygame.KEYDOWN and event.key == pygame.K_ESCAPE):
            return False
        if event.type == pygame.KEYDOWN:
            held.add(event.key)
        elif event.type == pygame.KEYUP:
            held.discard(event.key)
    return True


def _picture(loop: Loop, zoom: float) -> NDArray[np.uint8]:
    """Return the picture (H, W, 3) that the tracker gets, with its estimate, and what a second camera looks at."""
    picture = loop.seen.observation.image_rgb.copy()
    draw_steered(Canvas(picture, np.eye(2), np.zeros(2)), loop.seen)
    draw_place(picture, loop.estimate.position_px)
    enlarged: Any = cv2.resize(picture, None, fx=zoom, fy=zoom, interpolation=cv2.INTER_NEAREST)
    return np.asarray(enlarged, np.uint8)


def _write(
    settings: FollowSettings,
    seed: int,
    loop: Loop,
    sheet: ScoreSheet,
    seconds: float,
    out: Path,
    modules: tuple[str, ...],
) -> None:
    """Write the rows of an episode."""
    suite, tracker = controllers_suite(), tracker_named(settings.tracker)
    episode = simulated(settings.scenario, settings.preset_name, seed, renderer=settings.renderer)
    ending = {"seconds": round(seconds, 3), "editions": editions_of(suite, episode, tracker)}
    steering = Steering(HUMAN, episode.scenario.carrier.name, str(settings.link))
    job = Job(suite, replace(episode, steering=steering), {settings.tracker: tracker}, modules)
    heading = heading_of(job, settings.tracker, controller_role="external")
    scores = [(0, score) for score in sheet.scores(Ending())]
    append_block(out, block_of(suite, heading, scores, loop.episode.frame_count, ending))
