"""Records in ``vot_toolkit.json`` how the VOT toolkit reads regions, which tests compare ours with.

The toolkit is not a dependency, since it needs another OpenCV. In an environment of its own, from the root of a
checkout:

    pip install vot-toolkit==0.9.0 attributee==0.1.9
    python tests/trackers/record_vot_toolkit.py
"""

from __future__ import annotations

import json
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

FILE = Path(__file__).with_name("vot_toolkit.json")
HEIGHT_PX, WIDTH_PX = 30, 40
_COMMAND = "python tests/trackers/record_vot_toolkit.py"


def texts() -> list[str]:
    """Return texts of all kinds, by the rules and at random."""
    rng = np.random.default_rng(0)
    rectangles = [
        [3, 4, 7, 5],
        [2.5, 3.5, 4.5, 2.5],
        [-4.2, -3, 12, 9.7],
        [35, 25, 20, 20],
        [50, 2, 4, 4],
        [1, 1, 0, 0],
    ]
    rectangles += np.round(rng.uniform((-5, -5, 0, 0), (40, 30, 25, 25), (12, 4)), 2).tolist()
    polygons = [[2, 3, 12, 3, 12, 9, 2, 9], [5, 5, 20, 8, 9, 21], [-6, 4, 20, -7, 50, 40]]
    polygons += np.round(rng.uniform(-5, 45, (12, 8)), 1).tolist()
    masks = ["m0,0,3,2,1,2,2,1", "m5,6,4,3,0,12", "m5,6,4,3,0,3,6", "m0,0,0,0,0", "m7,8,2,2,4", "m38,28,4,4,0,16"]
    for density in (0.02, 0.5, 0.9):
        height, width = rng.integers(2, 9, 2)
        bits = rng.random(height * width) < density
        runs = np.diff(np.flatnonzero(np.diff(bits, prepend=False)), prepend=0, append=height * width)
        masks.append(f"m{rng.integers(9)},{rng.integers(9)},{width},{height},{','.join(map(str, runs))}")
    others = ["0", "1", "2", "-1", "nan,nan,nan,nan", "12.5,7.25", "nan,4"]
    return [*others, *(",".join(map(str, each)) for each in rectangles + polygons), *masks]


def _read(text: str) -> dict[str, Any]:
    from vot.region import Point, Special
    from vot.region.io import parse_region
    from vot.region.shapes import Polygon, Rectangle

    region = parse_region(text)
    known: dict[str, Any] = {"text": text, "kind": type(region).__name__}
    if isinstance(region, Special):
        return known | {"code": region.code}
    if isinstance(region, Point):
        return known | {"numbers": [region.x, region.y]}
    # Overlaps round first, see `vot.region.raster._infer_meta`.
    if isinstance(region, Rectangle):
        known["numbers"] = [region.x, region.y, region.width, region.height]
        drawn = Rectangle(*np.round(region._data).ravel())
    elif isinstance(region, Polygon):
        rectangle = Rectangle.convert(region)
        known["numbers"] = [rectangle.x, rectangle.y, rectangle.width, rectangle.height]
        drawn = region
    else:
        known["written"] = str(region)
        drawn = region
    pixels = drawn.rasterize((0, 0, WIDTH_PX - 1, HEIGHT_PX - 1))
    return known | {"rows": ["".join(map(str, row)) for row in pixels.tolist()]}


def main() -> None:
    """Write the file."""
    regions = [_read(each) for each in texts()]
    recorded = {"command": _COMMAND, "vot-toolkit": version("vot-toolkit"), "regions": regions}
    FILE.write_text(json.dumps(recorded, separators=(",", ":")) + "\n")


if __name__ == "__main__":
    main()
