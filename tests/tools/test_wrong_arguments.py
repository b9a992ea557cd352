"""Wrong arguments of the project's own tools: what was expected, and what came."""

from __future__ import annotations

import pytest

from tests.tools.command import tools


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["learn-colours", "--seeds", "10000:10001"], "expected development seeds, below 10000"),
        # The classes are the town's: no other scenario's colours may take their place.
        (["learn-colours", "--scenario", "stereo-follow"], "Unrecognized options: --scenario"),
    ],
)
def test_words_that_are_no_options_are_told(words: list[str], message: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as stop:
        tools(words)
    assert stop.value.code == 2
    assert message in capsys.readouterr().err


def test_a_wrong_value_is_one_line(capsys: pytest.CaptureFixture[str]) -> None:
    assert tools(["speed", "--frames", "7"]) == 2
    assert capsys.readouterr().err == "error: frames: expected a whole number >= 8, got 7\n"
