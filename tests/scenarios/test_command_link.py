"""Commands arrive limited, delayed and noisy as the link is configured."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from scenarios.command_link import LINKS, CommandLink, Link, link_named
from sim.rng import generator
from trackers.types import CameraCommand, Carrier, CommandAxis

RATE_HZ = 10.0
CARRIER = Carrier("cart", (CommandAxis("forward_mps", 2.0, 5.0), CommandAxis("yaw_rate_rad_s", 1.0, 100.0)), "ahead")
NUMBERS = st.floats(-10, 10)


def link(settings: Link = LINKS["prompt"], seed: int = 0) -> CommandLink:
    return CommandLink(CARRIER, RATE_HZ, settings, generator(seed, "link"))


@pytest.mark.parametrize("settings", [Link(), Link(delay_frames=3), Link(noise=0.1), Link(2, 0.05)])
def test_the_link_keeps_to_its_equations_to_the_last_bit(settings: Link) -> None:
    rng, sender, drawn = np.random.default_rng(5), link(settings, seed=2), generator(2, "link")
    limits, steps, latest = np.array([2.0, 1.0]), np.array([5.0, 100.0]) / RATE_HZ, np.zeros(2)
    waiting = [np.zeros(2)] * settings.delay_frames
    for _ in range(200):
        wanted = rng.normal(0, [3.0, 1.0])
        latest = np.clip(np.clip(wanted, -limits, limits), latest - steps, latest + steps)
        waiting.append(latest)
        obeyed = waiting.pop(0)
        if settings.noise > 0.0:
            obeyed = np.clip(obeyed + settings.noise * limits * drawn.normal(size=2), -limits, limits)
        got = sender.send(CameraCommand(forward_mps=wanted[0], right_mps=1.0, yaw_rate_rad_s=wanted[1]))
        assert got == CameraCommand(forward_mps=obeyed[0], yaw_rate_rad_s=obeyed[1])


@given(st.lists(st.tuples(NUMBERS, NUMBERS), min_size=1, max_size=20))
def test_commands_keep_to_range_and_slew(wanted: list[tuple[float, float]]) -> None:
    sender, before = link(), 0.0
    for forward, turn in wanted:
        got = sender.send(CameraCommand(forward_mps=forward, right_mps=3.0, yaw_rate_rad_s=turn))
        assert abs(got.forward_mps) <= 2.0
        assert abs(got.forward_mps - before) <= 5.0 / RATE_HZ + 1e-9
        assert got.yaw_rate_rad_s == np.clip(turn, -1.0, 1.0)
        assert got.right_mps == 0.0, "this carrier does not go sideways"
        before = got.forward_mps


def test_what_is_within_reach_is_obeyed_at_once() -> None:
    assert link().send(CameraCommand(forward_mps=0.4)) == CameraCommand(forward_mps=0.4)


def test_a_delay_is_so_many_frames() -> None:
    sender = link(Link(delay_frames=2))
    got = [sender.send(CameraCommand(yaw_rate_rad_s=turn)).yaw_rate_rad_s for turn in (0.1, 0.2, 0.3, 0.4)]
    assert got == [0.0, 0.0, 0.1, 0.2]


def test_noise_has_the_spread_and_mean_it_says() -> None:
    sender = link(Link(noise=0.1))
    got = np.array([sender.send(CameraCommand()).forward_mps for _ in range(4000)])
    # Standard errors: of the mean 0.2 / sqrt(4000), of the deviation about 0.2 / sqrt(8000).
    assert got.mean() == pytest.approx(0.0, abs=4 * 0.2 / 4000**0.5)
    assert got.std() == pytest.approx(0.2, abs=4 * 0.2 / 8000**0.5)


def test_the_same_generator_gives_the_same_noise() -> None:
    first, second = (link(LINKS["noisy"], seed=3) for _ in range(2))
    assert [first.send(CameraCommand()) for _ in range(5)] == [second.send(CameraCommand()) for _ in range(5)]


def test_a_command_that_is_not_finite_is_refused() -> None:
    with pytest.raises(ValueError, match="command: expected finite numbers, got"):
        link().send(CameraCommand(forward_mps=float("nan")))


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("delay_frames", -1),
        ("picture_delay_frames", -1),
        ("picture_delay_frames", True),
        ("noise", -0.1),
        ("noise", float("inf")),
    ],
)
def test_bad_links_are_refused(name: str, value: float) -> None:
    with pytest.raises(ValueError, match=f"{name}: expected"):
        Link(**{name: value})  # type: ignore[arg-type]


def test_an_unknown_preset_is_refused() -> None:
    assert link_named("delayed").delay_frames > 0
    with pytest.raises(ValueError, match="link: expected one of prompt, delayed, noisy, late, got 'slow'"):
        link_named("slow")
