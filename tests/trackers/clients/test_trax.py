from __future__ import annotations

import importlib.util
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from trackers.clients import trax
from trackers.clients.child import Limits, ProcessError
from trackers.clients.remote import Program, remote_tracker
from trackers.clients.trax import TraxTracker
from trackers.types import CameraModel, Observation

SERVERS = str(Path(__file__).with_name("trax_servers.py"))
SIZE = (31, 23)
HAS_REFERENCE = importlib.util.find_spec("trax") is not None
needs_reference = pytest.mark.skipif(not HAS_REFERENCE, reason="no vot-trax, whose wheel is for Linux on x86-64")
BOX = np.array([4.0, 3.0, 15.0, 12.0])


def picture(seed: int) -> Observation:
    image = np.random.default_rng(seed).integers(0, 256, (*SIZE[::-1], 3)).astype(np.uint8)
    return Observation(image, seed / 15, CameraModel(*SIZE, 30.0))


def started(*words: str) -> TraxTracker:
    program = Program((sys.executable, SERVERS, *words), limits=Limits(start_s=60.0, frame_s=60.0))
    tracker = remote_tracker(program, {}, np.random.default_rng(0))
    assert isinstance(tracker, TraxTracker)
    return tracker


@pytest.mark.parametrize(
    "words",
    [
        ("by-hand", "1", "path", "rectangle"),
        ("by-hand", "2", "memory", "polygon"),
        ("by-hand", "3", "buffer", "mask"),
        ("by-hand", "4", "path;memory", "mask;rectangle"),
        pytest.param(("reference", "4", "memory", "rectangle"), marks=needs_reference),
        pytest.param(("reference", "4", "path", "mask"), marks=needs_reference),
        pytest.param(("reference", "4", "buffer", "polygon"), marks=needs_reference),
    ],
    ids=" ".join,
)
def test_pictures_regions_and_properties_pass_both_ways(words: tuple[str, ...]) -> None:
    tracker = started(*words)
    tracker.initialise(picture(0), BOX)
    # The system counts in hundredths of a second: only the start is certain to take one.
    assert tracker.elsewhere_cpu_s > 0.0
    for k in (1, 2, 3):
        estimate = tracker.update(picture(k))
        np.testing.assert_array_equal(estimate.box_xyxy, BOX)
        np.testing.assert_array_equal(estimate.position_px, [9.5, 7.5])
        # The reference writes properties in single precision.
        assert estimate.in_view_probability == pytest.approx(picture(k).image_rgb.mean() / 255.0, abs=1e-6)
        assert (estimate.mask is not None) == (words[-1] == "mask")
    if estimate.mask is not None:
        assert estimate.mask[3:12, 4:15].all()
        assert estimate.mask.sum() == 9 * 11
    assert tracker.release(whole=True) == 0


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("9", "path", "rectangle"), "TraX, version: expected 1 to 4, got 9"),
        (("3", "path", "rectangle", "depth"), "TraX, channels: expected color or ir, got color;depth"),
        (("3", "url", "rectangle"), "TraX, image: expected memory, path or buffer, got url"),
        (("3", "path", "circle"), "TraX, region: expected rectangle, polygon or mask, got circle"),
        (("3", "path", "rectangle", "no-greeting"), "TraX, greeting: expected hello, got state"),
        (("3", "path", "rectangle", "twice"), "it answered before it was asked: b'@@TRAX:state"),
        (("3", "path", "rectangle", "quits"), "it quit: no more memory"),
        (("3", "path", "rectangle", "nonsense"), "region: expected a code, .*; got 'here'"),
    ],
)
def test_what_is_out_of_the_protocol_is_named(words: tuple[str, ...], message: str) -> None:
    def run() -> None:
        tracker = started("by-hand", *words)
        tracker.initialise(picture(0), BOX)
        tracker.update(picture(1))

    with pytest.raises((ProcessError, ValueError), match=message):
        run()


@given(st.lists(st.text(st.characters(codec="utf-8", exclude_characters="\r"))))
def test_arguments_of_any_text_are_read_back(arguments: list[str]) -> None:
    line = trax.written("state", *arguments)
    assert line.count(b"\n") == 1
    assert trax.whole(0, b"noise\n" + line + b"more") == len(b"noise\n" + line)
    name, words, properties = trax.read(b"noise\n" + line)
    assert name == "state"
    plain = [each for each in arguments if not trax._PROPERTY.fullmatch(each)]
    assert words == plain
    assert len(properties) <= len(arguments) - len(plain)


@pytest.mark.parametrize("said", [b"", b"@@TRAX:sta", b"noise", b"noise @@TRAX:hello\n", b"noise\n@@TRAX:hello"])
def test_half_a_message_is_none(said: bytes) -> None:
    assert trax.whole(0, said) is None


@pytest.mark.skipif(shutil.which("g++") is None, reason="no compiler of C++")
def test_the_example_in_cpp_follows_a_square(tmp_path: Path) -> None:
    source = Path(__file__).parents[3] / "examples" / "template_trax.cpp"
    command = ["g++", "-O2", "-Wall", "-Wextra", "-Werror", "-o", str(tmp_path / "template"), str(source)]
    subprocess.run(command, check=True)
    tracker = remote_tracker(Program((str(tmp_path / "template"),)), {}, np.random.default_rng(0))
    ground = np.random.default_rng(0).integers(0, 60, (90, 120, 3)).astype(np.uint8)
    look = np.random.default_rng(1).integers(100, 256, (12, 16, 3)).astype(np.uint8)
    for k in range(8):
        image = ground.copy()
        x, y = 20 + 7 * k, 30 + 3 * k
        image[y : y + 12, x : x + 16] = look
        seen = Observation(image, k / 15, CameraModel(120, 90, 100.0))
        if k == 0:
            tracker.initialise(seen, np.array([x, y, x + 16, y + 12], dtype=float))
        else:
            estimate = tracker.update(seen)
            np.testing.assert_array_equal(estimate.box_xyxy, [x, y, x + 16, y + 12])
            assert estimate.in_view_probability == 1.0
    tracker.release(whole=True)
