"""Many envs at a time without pictures, for training; ``error_model`` replaces picture and tracker."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, Literal, get_args

import gymnasium as gym
import numpy as np
from gymnasium.vector import AutoresetMode
from numpy.typing import NDArray

from scenarios import catalog
from scenarios.command_link import link_limits
from scenarios.envs.actions import checked_actions
from scenarios.envs.pictureless.bank import EpisodeBank, episode_bank, pictureless_of
from scenarios.envs.pictureless.episode_state import KernelWorld
from scenarios.envs.pictureless.error_kernel import error_record
from scenarios.envs.pictureless.error_model import ErrorModel, error_model
from scenarios.envs.reward import TERMS, Reward
from scenarios.envs.settings import KEYWORDS, FollowSettings
from scenarios.envs.truth_info import COMMANDS
from scenarios.envs.vector_results import check_open, checked_mask, final_infos, masked
from scenarios.visibility import shortest_length_px
from sim.checks import check, check_choice
from trackers.belief.features import FEATURES, features_of
from trackers.belief.kernel import BELIEF, SEEN_PROBABILITY, SIGHTING, update_beliefs
from trackers.controllers.catalogue import Kernel, controller_entry
from trackers.kernels.records import record_kernel
from trackers.protocols import Controller
from trackers.types import Carrier, Estimate, Observation

IN_VIEW, CENTRED, SIZE, EFFORT, LOSS, LENGTH_SHARE = range(6)


def weights_of(reward: Reward) -> NDArray[np.float64]:
    """Return the weights (6,) of a reward as ``terms_of`` reads them."""
    return np.array([reward.in_view, reward.centred, reward.size, reward.effort, reward.loss, reward.length_share])


@record_kernel()
def terms_of(
    states: Any,
    weights: NDArray[np.float64],
    loss_frames: int,
    width_px: float,
    limits: NDArray[np.float64],
    out: NDArray[np.float64],
) -> None:
    """Write the weighted terms (B, 5) of a step, in the order of ``scenarios.envs.reward.TERMS``."""
    for k in range(len(states)):
        state = states[k]
        effort, axes = 0.0, 0
        for axis in range(len(limits)):
            if limits[axis] > 0.0:
                effort += min((state.obeyed[axis] / limits[axis]) ** 2, 1.0)
                axes += 1
        length = max(state.length_px, shortest_length_px(width_px)) / (weights[LENGTH_SHARE] * width_px)
        out[k, 0] = weights[IN_VIEW] * state.in_view
        out[k, 1] = weights[CENTRED] * np.tanh(4.0 * state.centring**3)
        out[k, 2] = weights[SIZE] * np.exp(-0.5 * np.log(length) ** 2) * state.in_view
        out[k, 3] = -weights[EFFORT] * np.sqrt(effort / axes)
        out[k, 4] = -weights[LOSS] if state.frames_out == loss_frames else 0.0


class VectorKernelController:
    """A controller with a kernel over beliefs."""

    def __init__(self, parameters: Any, kernel: Kernel, interval_s: float, count: int) -> None:
        self._parameters = kernel.record(parameters)
        self._memory = np.zeros(count, kernel.memory)
        self._steer, self._interval_s = kernel.steer, interval_s

    def begin(self, which: NDArray[np.int64]) -> None:
        """Note that episodes begin in the envs ``which`` (K,)."""
        self._memory[which] = np.zeros(1, self._memory.dtype)

    def command(self, states: NDArray[np.void], beliefs: NDArray[np.void], out: NDArray[np.float64]) -> None:
        """Write commands (B, 4), the numbers of ``Carrier.commands``."""
        self._steer(beliefs, self._parameters, self._memory, states["steps"] * self._interval_s, out)


class SeparateControllers:
    """Any other controller: one object per env, called one after another, which is slow.

    It gets posteriors as Gaussians, which is less than the particles of the rendered env.
    """

    def __init__(self, create: Callable[[], Controller], carrier: Carrier, world: KernelWorld, count: int) -> None:
        self._create, self._world, self._carrier = create, world, carrier
        self._controllers = [create() for _ in range(count)]

    def begin(self, which: NDArray[np.int64]) -> None:
        """See ``VectorKernelController``."""
        for k in which:
            self._controllers[k] = self._create()

    def command(self, states: NDArray[np.void], beliefs: NDArray[np.void], out: NDArray[np.float64]) -> None:
        """See ``VectorKernelController``."""
        for k, controller in enumerate(self._controllers):
            given = controller.command(self.observation(states[k]), self.estimate(states[k]))
            out[k] = [getattr(given, name) for name in self._carrier.commands]

    def observation(self, state: Any) -> Observation:
        """Return what a controller is given of an env's state: time, cameras, measured poses; the picture is black."""
        watched, steered = self._world.cameras(state)
        picture = np.broadcast_to(np.uint8(0), (watched.camera.height_px, watched.camera.width_px, 3))
        time_s = float(state["steps"] * self._world.interval_s)
        return Observation(picture, time_s, watched.camera, ego=watched.ego, steered=steered)

    def estimate(self, state: Any) -> Estimate:
        """Return the tracker's answer in an env's state."""
        if state["known"] == 0.0:
            return Estimate(np.full(2, np.nan), in_view_probability=0.0)
        camera, looks = self._world.cameras(state)[0].camera, self._carrier.looks
        place_px = state["estimate_px"].copy()
        half_px = 0.5 * float(state["length_share"]) * camera.width_px
        spread_px = float(state["spread_m"]) * camera.focal_px / float(state["depth_m"])
        return Estimate(
            place_px,
            box_xyxy=np.concatenate([place_px - half_px, place_px + half_px]),
            in_view_probability=float(state["probability"]),
            covariance_px=None if looks == "ahead" else np.eye(2) * spread_px**2,
            depth_m=float(state["depth_m"]) if looks == "ahead" else None,
        )


class Pictures:
    """The pictures that have arrived of B envs, which may be late.

    Attributes:
        states, sightings: (B,) records of the frames that trackers and controllers see; those of the present, which the
            env changes in place, without a delay.
    """

    def __init__(self, states: NDArray[np.void], sightings: NDArray[np.void], delay_frames: int) -> None:
        """``states`` and ``sightings`` (B,) are those of the present."""
        self._now, self._delay, self._steps = (states, sightings), delay_frames, 0
        self._under_way = [np.zeros((delay_frames, *each.shape), each.dtype) for each in self._now]
        self.states, self.sightings = self._now if delay_frames == 0 else (each.copy() for each in self._now)

    def begin(self, which: NDArray[np.int64]) -> None:
        """Note that episodes have begun in the envs ``which`` (K,): their first picture is seen at once."""
        for now, under_way, seen in self._each():
            under_way[:, which] = seen[which] = now[which]

    def move(self) -> NDArray[np.int64] | slice:
        """Note that all envs are a frame further; return those of which a new picture has arrived."""
        for now, under_way, seen in self._each():
            place = self._steps % self._delay
            seen[:], under_way[place] = under_way[place], now
        self._steps += 1
        return np.flatnonzero(self.states["steps"] > 0) if self._delay else slice(None)

    def _each(self) -> Iterator[tuple[NDArray[np.void], NDArray[np.void], NDArray[np.void]]]:
        if self._delay:
            yield from zip(self._now, self._under_way, (self.states, self.sightings), strict=True)


VectorController = VectorKernelController | SeparateControllers


def vector_controller(settings: FollowSettings, carrier: Carrier, world: KernelWorld, count: int) -> VectorController:
    """Return the settings' controller for ``count`` envs. Raises ValueError for an unknown name or value."""
    entry, values = controller_entry(settings.controller, carrier.name), settings.controller_values
    if entry.kernel is not None:
        return VectorKernelController(entry.parameters(**values), entry.kernel, world.interval_s, count)
    return SeparateControllers(lambda: entry.create(**values), carrier, world, count)


Starts = Literal["episodes", "frame-outs"]
_OWN = ("max_episode_steps", "autoreset_mode", "starts", "seeds", "cache", "bank", "model")
_OPTIONS = ("episode_seed", "reset_mask")


class PicturelessVectorEnv(gym.vector.VectorEnv):
    """B envs with the observation ``track`` and the actions ``command`` and ``correction`` of ``FollowEnv``.

    Nothing is rendered: the target's path, the air and the walls are those of the rendered episodes with the same
    seeds, and an error model replaces picture and tracker. Check a policy trained here in the rendered env. Episodes
    are drawn from a bank. Where an episode ends, ``autoreset_mode`` says when another one begins, as Gymnasium defines
    it: within the same step, with the end in ``final_obs`` and ``final_info``; in the next step; or by a reset with the
    option ``reset_mask``. Infos are those of ``truth_info`` that need no picture.
    """

    metadata: dict[str, Any] = {"render_modes": []}

    def __init__(
        self,
        num_envs: int,
        scenario: str,
        tracker: str,
        *,
        max_episode_steps: int | None = None,
        autoreset_mode: AutoresetMode | str = AutoresetMode.SAME_STEP,
        starts: Starts = "episodes",
        seeds: Iterable[int] = range(256),
        cache: Path | str | None = None,
        bank: EpisodeBank | None = None,
        model: ErrorModel | None = None,
        **settings: Any,
    ) -> None:
        """Plan the bank's episodes, or read them.

        Args:
            max_episode_steps: longer episodes are truncated; None: at their last frame.
            autoreset_mode: ``SameStep``, ``NextStep`` or ``Disabled``; most of Gymnasium's wrappers take the last two.
            starts: ``episodes``: on frame 0, as in the rendered env; ``frame-outs``: shortly before a likely loss.
            seeds: episodes of the bank; those that are not stored yet are planned first, a second to a few each. cache:
                folder that stores planned episodes.
            bank: replaces ``seeds``; its configuration must be that of the settings.
            model: replaces the tracker's own error model.
            settings: those of ``FollowSettings`` that need no picture.
        """
        good = max_episode_steps is None or max_episode_steps >= 1
        check("max_episode_steps", good, "None or a whole number >= 1", max_episode_steps)
        self._mode = AutoresetMode(autoreset_mode)
        self.metadata = {**self.metadata, "autoreset_mode": self._mode}
        check_choice("starts", starts, get_args(Starts))
        for name in settings:
            check_choice("keywords", name, (*_OWN, *KEYWORDS))
        self.settings = _checked(FollowSettings(scenario, tracker, **settings))
        self.carrier = catalog.scenario(scenario).carrier
        preset = self.settings.configuration({})
        if bank is None:
            bank = _varied_bank(self.settings, [*seeds], None if cache is None else Path(cache))
        else:
            none = "nothing with a bank, whose episodes are planned"
            check("randomise", not self.settings.randomise, none, self.settings.randomise)
        check("bank", bank.preset == preset, f"episodes of the configuration {preset}", bank.preset)
        self.bank, self.num_envs = bank, num_envs
        self.progress = self.settings.progress
        model = error_model(scenario, tracker) if model is None else model
        wanted, got = f"one with an error model for {scenario}", f"one for {model.scenario}"
        check("tracker", model.scenario == scenario, wanted, got)
        self._at_frame_outs = starts == "frame-outs"
        self._most_steps = max_episode_steps or bank.frame_count
        link = link_limits(self.carrier, preset.rate_hz, self.settings.link_settings, self.carrier.commands)
        self._world: KernelWorld = pictureless_of(scenario).world(preset, bank.arrays, link, error_record(model))
        self._limits = link.limits
        self._controller: VectorController | None = None
        if self.settings.action == "correction":
            self._controller = vector_controller(self.settings, self.carrier, self._world, num_envs)
        # Actions have the order of the axes.
        self._obeyed = np.array([self.carrier.commands.index(axis.name) for axis in self.carrier.axes])
        self.single_observation_space = gym.spaces.Box(-1.0, 1.0, (len(FEATURES),), np.float32)
        self.single_action_space = gym.spaces.Box(-1.0, 1.0, (len(self._obeyed),), np.float32)
        self.observation_space = gym.vector.utils.batch_space(self.single_observation_space, num_envs)
        self.action_space = gym.vector.utils.batch_space(self.single_action_space, num_envs)
        self.states = np.zeros(num_envs, self._world.state_dtype)
        self.beliefs, self.sightings = np.zeros(num_envs, BELIEF), np.zeros(num_envs, SIGHTING)
        late_frames = self.settings.link_settings.picture_delay_frames
        self._pictures = Pictures(self.states, self.sightings, late_frames)
        self._waiting = np.zeros((num_envs, link.delay_frames, 4))
        self._wanted, self._terms = np.zeros((num_envs, 4)), np.zeros((num_envs, len(TERMS)))
        self._features = np.zeros((num_envs, len(FEATURES)), np.float32)
        self._weights = weights_of(self.settings.reward)
        self._loss_frames = max(round(self.settings.reward.loss_after_s / self._world.interval_s), 1)
        lost_after_s = self.settings.lost_after_s
        self._lost_frames = np.inf if lost_after_s is None else max(round(lost_after_s / self._world.interval_s), 1)
        self._begun = False
        # Whose episodes have ended, if no other has begun.
        self._over = np.zeros(num_envs, dtype=bool)

    def reset(
        self, *, seed: int | list[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[NDArray[np.float32], dict[str, Any]]:
        """Begin an episode in every env.

        Args:
            seed: of all random draws, which the envs share: a number, or one for each env (B,), None to leave it out.
            options: ``episode_seed``: the bank's episode for all envs, or for each (B,), from frame 0 on.
                ``reset_mask``: (B,) bool, the envs to reset; the others go on.
        """
        check_open(self)
        wanted = options or {}
        for name in wanted:
            check("options", name in _OPTIONS, f"keys among {', '.join(_OPTIONS)}", repr(name))
        mask = checked_mask(wanted.get("reset_mask"), self.num_envs, self._begun)
        which, at_frame_outs = np.flatnonzero(mask), self._at_frame_outs
        self._seed(seed)
        if "episode_seed" in wanted:
            seeds, at_frame_outs = np.broadcast_to(wanted["episode_seed"], self.num_envs)[which], False
            episodes = np.array([self.bank.index_of(int(each)) for each in seeds])
        else:
            episodes = self._drawn(len(which))
        self._begin(which, episodes, at_frame_outs)
        self._begun = True
        return self._observed(), masked(self._infos(), mask)

    def _seed(self, seed: Any) -> None:
        """Seed all random draws by a number, or by those of a list, one for each env."""
        several = isinstance(seed, Sequence | np.ndarray)
        known = [int(each) for each in (seed if several else [seed]) if each is not None]
        if known:
            # A list of one seeds as its number does.
            self._np_random = np.random.default_rng(known[0] if len(known) == 1 else known)
            self._np_random_seed = known[0]

    def step(
        self, actions: NDArray[Any]
    ) -> tuple[NDArray[np.float32], NDArray[np.float64], NDArray[np.bool_], NDArray[np.bool_], dict[str, Any]]:
        """Advance all envs by a frame.

        Raises:
            ResetNeeded: before the first reset, and with autoreset_mode ``Disabled`` after an end.
            ClosedEnvironmentError: after closing.
            ValueError: for actions of another shape, not finite, or outside [-1, 1] unless these are clipped.
        """
        check_open(self)
        if not self._begun:
            raise gym.error.ResetNeeded("step: expected reset() before it, got episodes not begun")
        again = self._over.copy()
        if again.any() and self._mode == AutoresetMode.DISABLED:
            wanted = "step: expected a reset with the option reset_mask of the envs whose episodes have ended"
            raise gym.error.ResetNeeded(f"{wanted}, got none of env {np.flatnonzero(again)[0]}")
        # They move with the others, within their episodes, and begin anew below.
        self.states["frame"][again] -= 1
        self._command(checked_actions(actions, self.action_space.shape, self.settings.out_of_range))
        self._world.move(self.states, self._wanted, self._waiting, self.sightings, self.np_random)
        arrived = self._pictures.move()
        beliefs = self.beliefs[arrived]
        update_beliefs(beliefs, self._pictures.sightings[arrived], self._world.interval_s)
        self.beliefs[arrived] = beliefs
        states = self.states
        if again.any():
            self._begin(np.flatnonzero(again), self._drawn(int(again.sum())), self._at_frame_outs)
        terms_of(states, self._weights, self._loss_frames, 2.0 * self._world.camera[1], self._limits, self._terms)
        self._terms[again] = 0.0
        terminated = (states["frames_out"] >= self._lost_frames) & ~again
        truncated = (states["frame"] + 1 >= self.bank.frame_count) | (states["steps"] >= self._most_steps)
        observed, rewards, infos = self._observed(), self._terms.sum(axis=1), self._infos()
        ended = terminated | truncated
        same_step = self._mode == AutoresetMode.SAME_STEP
        final = self._begun_again(ended, observed, infos) if same_step and ended.any() else {}
        self._over |= ended & (not same_step)
        infos = masked(self._infos() if final else infos, np.ones(self.num_envs, dtype=bool))
        return observed, rewards, terminated, truncated, infos | final

    def _begun_again(
        self, ended: NDArray[np.bool_], observed: NDArray[np.float32], infos: dict[str, Any]
    ) -> dict[str, Any]:
        """Begin new episodes where others have ended; return ``final_obs`` and ``final_info``."""
        which, last = np.flatnonzero(ended), observed.copy()
        self._begin(which, self._drawn(len(which)), self._at_frame_outs)
        observed[which] = self._observed()[which]
        return final_infos(last, infos, ended)

    @property
    def progress(self) -> float:
        """Of the training, see ``FollowSettings``; set it for later episodes.

        Where ``randomise`` is a curriculum, the first of the bank's episodes is planned for its beginning and the last
        one for its end; those that begin are drawn from the quarter that is nearest the progress.
        """
        return self.settings.progress

    @progress.setter
    def progress(self, progress: float) -> None:
        self.settings = replace(self.settings, progress=progress)
        self._playable = np.arange(len(self.bank.seeds))
        if self.settings.is_curriculum:
            away = np.abs(_progress_of(len(self.bank.seeds)) - progress)
            self._playable = np.argsort(away, kind="stable")[: max(len(away) // 4, 1)]

    def _drawn(self, count: int) -> NDArray[np.int64]:
        return self._playable[self.np_random.integers(len(self._playable), size=count)]

    def _begin(self, which: NDArray[np.int64], episodes: NDArray[np.int64], at_frame_outs: bool) -> None:
        self._waiting[which] = self._wanted[which] = self._terms[which] = 0.0
        self._over[which] = False
        self._world.begin(self.states, which, episodes, at_frame_outs, self.sightings, self.np_random)
        # As with pictures, where steps count alone.
        self.states["frames_out"][which] = 0
        self._pictures.begin(which)
        beliefs = np.zeros(len(which), BELIEF)
        update_beliefs(beliefs, self.sightings[which], self._world.interval_s)
        self.beliefs[which] = beliefs
        if self._controller is not None:
            self._controller.begin(which)

    def _command(self, actions: NDArray[np.float64]) -> None:
        """Write the commands (B, 4) of actions."""
        limits = self._limits[self._obeyed]
        if self._controller is None:
            self._wanted[:, self._obeyed] = np.clip(actions, -1.0, 1.0) * limits
            return
        self._controller.command(self._pictures.states, self.beliefs, self._wanted)
        own = np.clip(self._wanted[:, self._obeyed] / limits, -1.0, 1.0)
        corrected = np.clip(own + self.settings.correction_share * actions, -1.0, 1.0) * limits
        if self.settings.corrects == "unseen":
            states = self._pictures.states
            seen = (states["known"] > 0.0) & (states["probability"] >= SEEN_PROBABILITY)
            corrected[seen] = self._wanted[:, self._obeyed][seen]
        self._wanted[:, self._obeyed] = corrected

    def _observed(self) -> NDArray[np.float32]:
        """Return the beliefs' features (B, F) as a new array."""
        shares = self._wanted / np.where(self._limits > 0.0, self._limits, np.inf)
        features_of(self.beliefs, np.clip(shares, -1.0, 1.0), self._features)
        return np.clip(self._features, -1.0, 1.0)

    def _infos(self) -> dict[str, Any]:
        """Return the truth as in ``truth_info``: arrays (B, ...)."""
        states, seen = self.states, self._pictures.states
        known = seen["known"] > 0.0
        command = np.zeros((self.num_envs, len(COMMANDS)))
        command[:, [COMMANDS.index(name) for name in self.carrier.commands]] = states["obeyed"]
        return {
            "episode_seed": self.bank.seeds[states["episode"]],
            "frame": states["frame"].copy(),
            "time_s": states["frame"] * self._world.interval_s,
            "in_view": states["in_view"] > 0.0,
            "centring": states["centring"].copy(),
            "length_px": states["length_px"].copy(),
            "position_px": np.nan_to_num(states["target_px"], nan=np.inf),
            "error_px": np.where(known, seen["error_px"], np.inf),
            "command": command,
            **{f"reward_{term}": self._terms[:, k].copy() for k, term in enumerate(TERMS)},
        }


def _progress_of(count: int) -> NDArray[np.float64]:
    """Return the progress (E,) for which each of E episodes is planned."""
    return np.linspace(0.0, 1.0, count)


def _varied_bank(settings: FollowSettings, seeds: list[int], cache: Path | None) -> EpisodeBank:
    """Return episodes of which each has its own values of the fields in ``randomise``."""
    own = []
    if settings.randomise:
        progress = _progress_of(len(seeds)).tolist() if settings.is_curriculum else [None] * len(seeds)
        own = [settings.configuration_of(*each) for each in zip(seeds, progress, strict=True)]
    return episode_bank(settings.scenario, settings.configuration({}), seeds, cache, own=own)


def _checked(settings: FollowSettings) -> FollowSettings:
    """Return settings that need no picture, or raise ValueError."""
    check("tracker", isinstance(settings.tracker, str), "the name of one with an error model", repr(settings.tracker))
    check("observation", settings.observation == "track", "'track' without pictures", repr(settings.observation))
    known = ("command", "correction")
    check("action", settings.action in known, f"one of {', '.join(known)} without pictures", repr(settings.action))
    check("controller", isinstance(settings.controller, str), "the name of one", repr(settings.controller))
    for name in pictureless_of(settings.scenario).fixed_fields:
        check("randomise", name not in settings.randomise, "fields that plans alone depend on", repr(name))
    check("worlds", not settings.worlds, "0 without pictures, where there are none", settings.worlds)
    return settings
