"""DAVIS: pictures and masks of objects as PNG with a palette (https://davischallenge.org).

Pont-Tuset et al., The 2017 DAVIS challenge on video object segmentation, https://arxiv.org/abs/1704.00675.
"""

from __future__ import annotations

import importlib

import numpy as np
from numpy.typing import NDArray

from benchmarks.data.exports.exporter import Exporter, export_format
from benchmarks.data.sets.channels import CODINGS, LOSSY
from benchmarks.data.sets.stored_episode import StoredEpisode
from scenarios import catalog
from sim.checks import check

_MOST_OBJECTS = 254
"""255 stands for what does not count."""
_BITS = 8


@export_format("davis")
class Davis(Exporter):
    """Masks of the objects that the first picture shows, for trackers that are given those.

    Format: DAVIS 2017, https://davischallenge.org (Pont-Tuset et al. 2017, arXiv 1704.00675), as its evaluation and
    trackers of masks read it. A sequence has the pictures `JPEGImages/480p/NAME/FFFFF.jpg`, of whatever size, and the
    masks `Annotations/480p/NAME/FFFFF.png`, of frames from 0 on. `ImageSets/2017/train.txt` and `val.txt` (and
    `test.txt`) name the sequences of the set's splits; in a set without shares, episodes of the benchmark's test split
    are in `val.txt`. Pictures that were stored without loss become JPEG of quality 95.

    A pixel of a mask is the number of the object that is seen there, 0 for none. Objects that the first picture shows
    are counted from 1 and keep their numbers; the target is the first of them, if the scene has one. Since a tracker is
    given the masks of the first picture, objects that come later are in no mask, and a sequence whose first picture
    shows none is left out. The palette is that of PASCAL VOC, as in DAVIS. `objects.csv` gives the sequence, number,
    name, kind and class of each object.
    """

    channels = ("image_rgb", "instance_map")
    packages = ("PIL",)
    has_classes = True

    def begin(self) -> None:
        """Begin the lists of sequences and objects."""
        self._names: dict[str, list[str]] = {"train": [], "val": []}
        self._objects = ["sequence,number,name,kind,class"]

    def write_episode(self, episode: StoredEpisode) -> None:
        """Write pictures and masks."""
        name, numbers = self.name_of(episode), dict[int, int]()
        for stored in self.frames(episode):
            truth = stored.frame.truth
            if stored.index == 0:
                shown = [each for each in self.labels.instances(stored) if each.is_seen and each.name in truth.names]
                shown.sort(key=lambda each: each.name != catalog.scenario(self.data.request.scenario).target)
                check("data", len(shown) <= _MOST_OBJECTS, f"at most {_MOST_OBJECTS} objects in a picture", len(shown))
                numbers = {each.instance_id: number for number, each in enumerate(shown, start=1)}
                if not numbers:
                    return
                for each in shown:
                    row = (name, numbers[each.instance_id], each.name, each.kind, self.labels.class_of(each.kind))
                    self._objects.append(",".join(map(str, row)))
            mask = np.zeros(truth.instance_map.shape, np.uint8)
            for identity, number in numbers.items():
                mask[truth.instance_map == identity] = number
            self._write_mask(mask, f"Annotations/480p/{name}/{stored.index:05d}.png")
            content = _as_jpeg(episode, stored.index)
            self.place(f"JPEGImages/480p/{name}/{stored.index:05d}.jpg").write_bytes(content)
        split = self.data.request.split_of(episode.seed)
        self._names.setdefault("val" if split == "test" and not self.data.request.splits else split, []).append(name)

    def end(self) -> None:
        """Write the lists of sequences and objects."""
        check("data", any(self._names.values()), "an episode whose first picture shows an object", "none")
        for split, names in self._names.items():
            self.write_lines(f"ImageSets/2017/{split}.txt", names)
        self.write_lines("objects.csv", self._objects)

    def _write_mask(self, mask: NDArray[np.uint8], path: str) -> None:
        image = importlib.import_module("PIL.Image").fromarray(mask)
        image.putpalette(palette().tobytes())
        image.save(self.place(path), format="PNG")


def palette() -> NDArray[np.uint8]:
    """Return the colours (256, 3) of PASCAL VOC: of a number's bits, from the lowest on, red, green and blue get one in
    turn, and each begins with its highest.
    """
    number, place = np.arange(2**_BITS)[:, None, None], np.arange(3)[:, None]
    rounds = np.arange(_BITS)
    bits = (number >> (3 * rounds + place)) & 1
    return (bits << (_BITS - 1 - rounds)).sum(axis=2).astype(np.uint8)


def _as_jpeg(episode: StoredEpisode, index: int) -> bytes:
    stored = episode.coded(index, "image_rgb")
    assert stored is not None, "every frame has a picture"
    coding, content = stored
    return content if coding == LOSSY else CODINGS[LOSSY].encode(CODINGS[coding].decode(content))
