"""Wrong arguments of the project's own tools: one line says what was expected and what came."""

from __future__ import annotations

import re

import pytest

from tests.tools.command import tools


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (
            ["learn-colours", "--seeds", "10000:10001"],
            "seeds: expected development seeds, below 10000, got '10000:10001'",
        ),
        (
            # The classes are the town's: no other scenario's colours may take their place.
            ["learn-colours", "--scenario", "stereo-follow"],
            "arguments: expected options of `python -m tools learn-colours --help`, got '--scenario'",
        ),
        (["speed", "--frames", "7"], "frames: expected a whole number >= 8, got 7"),
        (["speed", "--resets", "--stored"], "resets: expected one of --stored, --resets, got both"),
        (["speed", "paper-sheet", "--resets", "--preset", "paper-b1"], "resets: expected scenarios with an env, got"),
    ],
)
def test_a_wrong_argument_is_one_line(words: list[str], message: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert tools(words) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert re.match(f"error: {message}", line)
