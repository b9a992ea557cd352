"""What a user's code raises is told in one line that can be printed, whatever its text is."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from benchmarks.run.failures import reason_of
from benchmarks.run.own_inputs import own


class Wordless(Exception):
    """Its text raises."""

    def __str__(self) -> str:
        raise ValueError("no words")


@pytest.mark.parametrize(
    ("error", "reason"),
    [
        (RuntimeError("a bug\nin two lines"), "RuntimeError: a bug"),
        (RuntimeError(), "RuntimeError: "),
        (RuntimeError("\n\n  a bug"), "RuntimeError: a bug"),
        (RuntimeError("\x1b[31mred\x07\ud800"), "RuntimeError:  [31mred  "),
        (RuntimeError("x" * 10_000), "RuntimeError: " + "x" * 300),
        (Wordless(), "Wordless: (it has no text that can be read)"),
        (RuntimeError("a read-only disk"), "RuntimeError: a read-only disk"),
    ],
)
def test_the_first_line_that_can_be_printed(error: Exception, reason: str) -> None:
    assert reason_of(error) == reason
    reason_of(error).encode()


@pytest.mark.parametrize("grey", [False, True])
def test_who_draws_on_a_picture_is_told_to_copy_it(grey: bool) -> None:
    picture = np.zeros((8, 8, 3), np.uint8)
    image = own(np.broadcast_to(picture[..., :1], picture.shape) if grey else picture)
    with pytest.raises(cv2.error) as drawn:
        cv2.circle(image, (3, 3), 2, (1, 2, 3))
    with pytest.raises(ValueError, match="read-only") as assigned:
        image[0] = 1
    with pytest.raises(ValueError, match="WRITEABLE") as made_writeable:
        image.flags.writeable = True
    for error in (drawn, assigned, made_writeable):
        assert reason_of(error.value).endswith("read-only: change a copy, image = observation.image_rgb.copy()")
    assert "circle" in reason_of(drawn.value)
