"""Train the detector of ``train_detector`` on data sets, and print its AP at an IoU of 0.5 on real cars from above.

Needs `pip install 'frameout[data,train]'`. The stills, four from a drone and one aerial, are downloaded from where they
lie, or put into the folder by hand: they may be tried, not passed on. `real_stills.json` has addresses, licences, and
90 cars that we labelled by hand. Each still is made smaller until its cars are as long as those of the data set::

    frameout generate --config examples/towns.yaml --out sets
    python examples/real_stills.py --data sets/next --steps 400 --pictures results/stills --show results/found

After 12 towns of `road-town-v3` in any weather (7 minutes of one core in all) AP is 0.25: 0.24, 0.61, 0.24, 0.00 and
0.20 in the stills, 0.69 on four other towns. After 12 of `road-town-v2` (`--data sets/old`) it is 0.19: 0.12, 0.63,
0.02, 0.00 and 0.26 (0.64 on the four); one seed and five stills are too few to rank the two. Boxes at random have 0.00.
Many finds are roughly placed: at an IoU of 0.3 AP is 0.50 and 0.44. By eye, neighbours in a row melt into one box, as
the town's car parks have no full rows; ends of school buses, planters and shadows pass for cars; some cars, dark and
white, are missed.
"""

from __future__ import annotations

import hashlib
import json
import sys
from dataclasses import dataclass
from http.client import HTTPException
from pathlib import Path
from urllib.request import urlopen

import cv2
import numpy as np
import tyro
from detections import Boxes, average_precision, cars_seen
from numpy.typing import NDArray
from train_detector import detect, picture_and_goals, picture_of, train

from benchmarks.data.pictures import read_picture
from benchmarks.data.sets.data_set import DataSet
from sim.checks import check

MOST = 100
"""Boxes that are judged in a still."""


@dataclass(frozen=True)
class Still:
    """A picture from elsewhere, and the boxes x_min, y_min, x_max, y_max in pixels that we drew on it by hand.

    Attributes:
        name: of the file. url, licence, sha256: where it is, its terms, and of its bytes.
        car_px: length of a car in it.
        cars: without their shadows. unclear: hidden, cut by the border, trailers, golf carts: not judged.
    """

    name: str
    url: str
    licence: str
    sha256: str
    car_px: float
    cars: list[list[float]]
    unclear: list[list[float]]

    @property
    def boxes(self) -> Boxes:
        """Return the boxes as ``cars_seen`` has them."""
        return np.array([(*box, 1) for box in self.cars] + [(*box, 0) for box in self.unclear], float)

    def picture(self, folder: Path) -> NDArray[np.uint8]:
        """Return the picture (H, W, 3) from a folder, into which it is downloaded if it is not there.

        Raises:
            ValueError: if neither is possible, or it is another picture.
        """
        path = folder / self.name
        is_here = path.exists()
        if is_here:
            content = path.read_bytes()
        else:
            try:
                with urlopen(self.url, timeout=60) as answer:
                    content = answer.read()
            except (OSError, HTTPException) as error:
                raise ValueError(
                    f"pictures: expected {path}, or an answer from {self.url}, got neither ({error})"
                ) from None
        digest, source = hashlib.sha256(content).hexdigest(), path if is_here else self.url
        check("pictures", digest == self.sha256, f"{source} as it was labelled, sha256 {self.sha256}", digest)
        if not is_here:
            folder.mkdir(parents=True, exist_ok=True)
            path.write_bytes(content)
        return read_picture(path)


def stills() -> list[Still]:
    """Return the stills of ``real_stills.json``."""
    return [Still(**each) for each in json.loads(Path(__file__).with_suffix(".json").read_text())]


def resized(picture: NDArray[np.uint8], boxes: Boxes, scale: float) -> tuple[NDArray[np.uint8], Boxes]:
    """Return a picture that is smaller by the factor ``scale``, up to whole pixels, and its boxes there."""
    (height, width), old = np.maximum(np.round(np.array(picture.shape[:2]) * scale), 1).astype(int), picture.shape
    factor = np.array([width / old[1], height / old[0]] * 2 + [1])
    return np.asarray(cv2.resize(picture, (width, height), interpolation=cv2.INTER_AREA), np.uint8), boxes * factor


def length_of_cars(frames: DataSet) -> float:
    """Return the median of the longer sides of boxes of cars that count, in every 16th picture of a set, in pixels."""
    samples = frames.samples(cars_seen)
    boxes = np.concatenate([samples[k] for k in range(0, len(samples), 16)])
    sides = boxes[boxes[:, 4] == 1, 2:4] - boxes[boxes[:, 4] == 1, :2]
    return float(np.median(sides.max(axis=1)))


def by_chance(still: Still, shape: tuple[int, ...], rng: np.random.Generator) -> Boxes:
    """Return ``MOST`` boxes of the size of a car, upright or across, anywhere in a picture, with any score."""
    sides = rng.permuted(np.tile(still.car_px * np.array([1, 0.45]), (MOST, 1)), axis=1)
    low = rng.uniform(size=(MOST, 2)) * (np.array([shape[1], shape[0]]) - sides)
    return np.column_stack([low, low + sides, rng.uniform(size=MOST)])


def report(name: str, found: list[tuple[Boxes, Boxes]]) -> None:
    """Print the AP of what was found over all stills, and in each."""
    each = " ".join(f"{average_precision([pair]):.2f}" for pair in found)
    print(f"{name}: AP {average_precision(found):.3f} ({each})")


def draw(picture: NDArray[np.uint8], truth: Boxes, found: Boxes, path: Path) -> None:
    """Write a picture with the cars in green, unclear ones in yellow, and as many best finds as cars in red."""
    drawn, best = cv2.cvtColor(picture, cv2.COLOR_RGB2BGR), np.argsort(-found[:, 4])[: int(truth[:, 4].sum())]
    for boxes, colour in (
        (truth[truth[:, 4] == 0], (0, 255, 255)),
        (truth[truth[:, 4] == 1], (0, 255, 0)),
        (found[best], (0, 0, 255)),
    ):
        for x0, y0, x1, y1 in boxes[:, :4].round().astype(int).tolist():
            cv2.rectangle(drawn, (x0, y0), (x1, y1), colour)
    path.parent.mkdir(parents=True, exist_ok=True)
    cv2.imwrite(str(path), drawn)


def main(
    data: list[str], pictures: Path = Path("results/stills"), steps: int = 800, seed: int = 0, show: str = ""
) -> None:
    """Train on each of the data sets ``data``, and print the AP on the stills in the folder ``pictures``.

    Args:
        show: folder for the stills with what was found, one folder for each data set.
    """
    tried = [(still, still.picture(pictures)) for still in stills()]
    rng = np.random.default_rng(seed)
    report("by chance", [(still.boxes, by_chance(still, picture.shape, rng)) for still, picture in tried])
    for url in data:
        frames = DataSet(url)
        car_px, (model, _) = length_of_cars(frames), train(frames.samples(picture_and_goals), steps, seed)
        found = []
        for still, picture in tried:
            small, truth = resized(picture, still.boxes, car_px / still.car_px)
            found.append((truth, detect(model, picture_of(small), MOST).numpy()))
            if show:
                draw(small, *found[-1], Path(show) / Path(url).name / still.name)
        report(url, found)


if __name__ == "__main__":
    try:
        tyro.cli(main)
    except ValueError as error:
        print(f"error: {error}", file=sys.stderr)
        sys.exit(2)
