"""Room for one row of pixels on its way through all stages of ``sim.render.pipeline``."""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from sim.render.attributes import RowRoom, new_row_room
from sim.render.runs import new_bench
from sim.sensors.noise import DarkRoom, new_dark_room
from sim.shaders.baked.panel_kernels import BENCH_LINES
from sim.shaders.baked.shader_kernels import AT_ROWS, ROOM_ROWS


class WorkRoom(NamedTuple):
    """What the pipeline's kernel works in, see the kernels that it calls."""

    row: RowRoom
    dark: DarkRoom
    colour: NDArray[np.uint32]
    room: NDArray[np.float32]
    at: NDArray[np.uint32]
    bench: NDArray[np.float32]


@lru_cache(maxsize=4)
def work_room(width: int) -> WorkRoom:
    """Return room for rows of ``width`` pixels: the same every time, as fresh memory costs a tenth of a millisecond."""
    return WorkRoom(
        new_row_room(width),
        new_dark_room(width),
        np.empty(width, np.uint32),
        np.empty((ROOM_ROWS, width), np.float32),
        np.empty((AT_ROWS, width), np.uint32),
        new_bench(BENCH_LINES, width),
    )
