"""Small data sets of a fake scene, which takes no time to draw."""

from __future__ import annotations

from benchmarks.data.sets.data_set import DataSet
from benchmarks.data.sets.generating import Workers, generate
from benchmarks.data.sets.request import Request
from tests import fakes_scenario

MODULES = (fakes_scenario.__name__,)
CHANNELS = ("image_rgb", "instance_map", "depth_m", "flow_px", "normal_world")
HERE = Workers(0, modules=MODULES)


def tiny(frame_count: int = 12, **changes) -> Request:
    """Return a request of two episodes of twelve frames."""
    asked = {"seeds": (3, 5), "channels": CHANNELS, "preset": f"tiny[frame_count={frame_count}]"} | changes
    return Request("fake-town-v1", **asked)


def made(request: Request, out, workers: Workers = HERE) -> DataSet:
    """Make a data set without a progress bar."""
    return generate(request, str(out), workers, lambda done, of: None)
