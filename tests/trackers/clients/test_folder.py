from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from trackers.clients.child import Limits, ProcessError
from trackers.clients.folder import answers_on
from trackers.types import Estimate

PROGRAM = str(Path(__file__).with_name("vots_program.py"))
PLACES = [(10, 20), (14, 22), None, (30, 5)]
BOX = np.array([8.0, 17.0, 13.0, 24.0])


def pictures() -> Any:
    for place in PLACES:
        image = np.full((40, 60, 3), 90, np.uint8)
        if place is not None:
            image[place[1], place[0]] = (250, 20, 20)
        yield image


def answers(*fault: str, **limits: float) -> tuple[list[Estimate], float]:
    return answers_on([sys.executable, PROGRAM, *fault], {}, Limits(**limits), pictures(), lambda: BOX)


def test_a_whole_sequence_goes_out_and_answers_come_back() -> None:
    estimates, cpu_s = answers()
    assert 0.0 < cpu_s < 5.0
    for place, estimate in zip(PLACES, estimates, strict=True):
        if place is None:
            assert np.isnan(estimate.position_px).all()
            assert estimate.in_view_probability is None
        else:
            np.testing.assert_allclose(estimate.position_px, np.array(place) + 0.5)
            np.testing.assert_allclose(estimate.box_xyxy[2:] - estimate.box_xyxy[:2], BOX[2:] - BOX[:2])
            assert estimate.in_view_probability == 0.75


@pytest.mark.parametrize(
    ("fault", "message"),
    [
        ("fails", "it ended with exit status 1: no memory left"),
        ("silent", r"expected a file output_obj0\.txt at its end, got none"),
        ("pipe", r"expected a file output_obj0\.txt at its end, got none"),
        ("huge", r"output_obj0\.txt: expected at most 1,073,741,824 bytes, got 1,099,511,627,776"),
        ("short", r"output_obj0\.txt: expected a line for each of 4 pictures, got 3"),
        ("nonsense", r"output_obj0\.txt, line 3: region: expected .*; got 'here'"),
    ],
)
def test_what_a_program_does_wrong_is_named(fault: str, message: str) -> None:
    with pytest.raises(ProcessError, match=message):
        answers(fault)


def test_it_may_take_no_longer_than_all_pictures_may() -> None:
    with pytest.raises(ProcessError, match=r"it did not answer within 0\.05 s"):
        answers(start_s=0.01, frame_s=0.01)
