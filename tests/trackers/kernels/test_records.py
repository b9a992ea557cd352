"""Compiled forms of a function for different records are told apart, whichever process compiled them."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from numba import from_dtype

import trackers.kernels.records  # noqa: F401


def test_the_name_of_a_records_type_is_that_of_its_fields() -> None:
    fields = [("a", "f8"), ("b", "i8")]
    several = [from_dtype(np.dtype(each)) for each in (fields, fields[::-1], fields[:1], [("a", "f8"), ("b", "f8")])]
    assert len({each.mangling_args for each in several}) == 4
    before = several[0].mangling_args
    # A number that numba gives to each type as it comes, and names a record's type after.
    several[0]._code += 1000
    assert several[0].mangling_args == before


STEERS = """
import sys
import numpy as np
from trackers.belief.kernel import BELIEF
from trackers.controllers.centring import CentreController, SearchController

belief = np.zeros(1, BELIEF)
for name, value in {"known": 1, "depth_m": 50, "axis_depth_m": 50, "height_m": 50, "ahead_m": 3}.items():
    belief[name] = value
for word in sys.argv[1:]:
    controller = CentreController if word == "centre" else SearchController
    kernel, out = controller.KERNEL, np.zeros((1, 4))
    kernel.steer(belief, kernel.record(controller.Parameters()), np.zeros(1, kernel.memory), np.zeros(1), out)
    print(out[0].tolist())
"""


@pytest.mark.heavy
def test_a_process_that_loads_what_two_others_compiled_calls_the_right_one(tmp_path: Path) -> None:
    """Two controllers share a function that takes the memory of either: one answered as the other."""

    def steered(*controllers: str) -> list[str]:
        environment = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path)}
        command = [sys.executable, "-c", STEERS, *controllers]
        return subprocess.run(command, env=environment, capture_output=True, text=True, check=True).stdout.splitlines()

    alone = [*steered("centre"), *steered("search")]
    assert steered("centre", "search") == alone
    assert steered("search", "centre") == alone[::-1]
