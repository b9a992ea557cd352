"""What the READMEs of data sets and of all exports share: the axes of their numbers, and the head for catalogues."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator
from fnmatch import fnmatch

from benchmarks.contract.rows import TEST_SPLIT
from benchmarks.data.sets.data_set import DataSet

COORDINATES = """
## Axes and pixels

- The world is in metres, z up. `T_world_X` (4, 4) takes coordinates of X to the world; translations are in its last
  column.
- The camera has x to the right, y down and z forward, along the optical axis (as OpenCV has it). `depth_m` is z.
  Normals (`normal_world`) are unit vectors in the world.
- An object's x is forward, y to the left, z up. Its origin is below its middle, where it touches the ground or the
  water; a fish has it at its underside, a sheet of paper in the middle of its lower edge. `bounds_m` tells where the
  body ends on each axis.
- Pixel coordinates are x to the right and y down. The first pixel covers 0 to 1 on both axes: its centre is at
  (0.5, 0.5), the picture's at (width / 2, height / 2), which is the principal point; pixels are square, and nothing is
  distorted. Where a format begins elsewhere, its part of this file says so.
- `flow_px` leads from a pixel of this picture to the same point in the previous one.
"""
_SIZES = ("n<1K", "1K<n<10K", "10K<n<100K", "100K<n<1M", "1M<n<10M", "10M<n<100M", "100M<n<1B")
"""Words of the Hugging Face Hub for powers of ten of samples."""
_TASKS = {
    "instance_map": ("object-detection", "image-segmentation"),
    "depth_m": ("depth-estimation",),
}
"""Channel -> tasks of the Hub that it is truth for."""


def split_of(seed: int) -> str:
    """Return ``test`` for a seed of the test split, else ``train``."""
    return "test" if seed in TEST_SPLIT else "train"


def hub_head(data: DataSet, configs: dict[str, dict[str, list[str]]]) -> str:
    """Return the head in YAML by which the Hugging Face Hub lists a data set and ``load_dataset`` finds its splits.

    Args:
        configs: name of a configuration -> split -> patterns of files; the first one is the default.
    """
    request = data.request
    power = len(str(max(len(data) - 1, 0))) - 3
    tasks = [task for channel, of in _TASKS.items() if channel in request.channels for task in of]
    # A string of JSON is one of YAML, whatever it holds.
    lines = [
        "license: mit",
        f"pretty_name: {json.dumps(f'Frameout {request.scenario}, {request.preset}')}",
        *_listed("task_categories", tasks),
        *_listed("tags", ["synthetic", "simulation", "visual-tracking", "frameout", request.scenario]),
        *_listed("size_categories", [_SIZES[min(max(power, 0), len(_SIZES) - 1)]]),
    ]
    if configs:
        lines.append("configs:")
    for number, (name, splits) in enumerate(configs.items()):
        lines += [f"- config_name: {name}", *(["  default: true"] if number == 0 else []), "  data_files:"]
        for split, patterns in splits.items():
            lines += [f"  - split: {split}", "    path:", *(f"    - {json.dumps(pattern)}" for pattern in patterns)]
    return "\n".join(["---", *lines, "---", "", ""])


def table_configs(data: DataSet) -> dict[str, dict[str, list[str]]]:
    """Return the configurations of a data set's tables: frames, objects and what stands about."""
    test = f"{TEST_SPLIT.start // 10_000:02d}*"
    folders = {"train": ["00*", "0[2-9]*", "[1-9]*"], "test": [test]}
    found = {
        split: [each for each in patterns if any(fnmatch(f"{seed:06d}", each) for seed in data.seeds)]
        for split, patterns in folders.items()
    }
    return {
        table: {
            split: [f"episodes/{folder}/{table}.parquet" for folder in patterns]
            for split, patterns in found.items()
            if patterns
        }
        for table in data.tables
    }


def _listed(name: str, values: Iterable[str]) -> Iterator[str]:
    values = list(values)
    if values:
        yield f"{name}:"
        yield from (f"- {json.dumps(value)}" for value in values)
