"""MOTS: a mask and an identity of each object, as run lengths (https://www.vision.rwth-aachen.de/page/mots).

Voigtlaender et al., MOTS: multi-object tracking and segmentation, CVPR 2019. TrackEval reads it as KITTI MOTS:
https://github.com/JonathonLuiten/TrackEval/blob/master/docs/KITTI-format.txt.
"""

from __future__ import annotations

from collections import Counter

import numpy as np

from benchmarks.data.codec import runs_of
from benchmarks.data.exports.exporter import Exporter, export_format
from benchmarks.data.mots_text import IGNORED
from benchmarks.data.sets.stored_episode import StoredEpisode
from sim.checks import check

CLASSES = {"car": 1, "person": 2}
"""Numbers of the classes that MOTS has; its pedestrians are persons here."""
OTHERS_FROM = IGNORED + 1
"""Number of the first other class."""
IDS_OF_CLASS = 1000


@export_format("mots")
class Mots(Exporter):
    """Masks with identities, a text file for each episode.

    Format: MOTS, https://www.vision.rwth-aachen.de/page/mots (Voigtlaender et al., CVPR 2019), in the folders of KITTI
    MOTS, as TrackEval reads it: `run_kitti_mots.py --GT_FOLDER . --SPLIT_TO_EVAL training`, where an answer is a folder
    `TRACKER/data` with files of the same kind as those of `label_02/`. (TrackEval 1.3 cannot read a list of one
    sequence.)

    `sequences.csv` gives the number, seed and name of each sequence, `evaluate_mots.seqmap.training` the number of its
    last frame. A row of `label_02/NNNN.txt` is frame, identity, class, height, width of the picture and the mask: run
    lengths as of COCO (`pycocotools.mask.decode({"size": [height, width], "counts": mask})`). Frames are counted from
    0, as the pictures `training/image_02/NNNN/FFFFFF` are. The identity is 1000 times the class plus the number of the
    object, which is the same in all pictures of a sequence. Cars have the class 1, persons 2, others 11 and up, in the
    order of the scene's own list. Each object has a row where at least one pixel of it is seen, those too that only
    stand about; masks do not overlap, and nothing is left out as not annotated.
    """

    channels = ("image_rgb", "instance_map")
    packages = ("pycocotools",)
    has_classes = True
    leaves_out = True

    def begin(self) -> None:
        """Begin the list of sequences."""
        self._sequences, self._ends = ["number,seed,name"], list[str]()

    def write_episode(self, episode: StoredEpisode) -> None:
        """Write pictures and rows."""
        number = f"{len(self._ends):04d}"
        rows, identities, used = list[str](), dict[str, int](), Counter[int]()
        for stored in self.frames(episode):
            self.write_picture(stored, f"training/image_02/{number}/{stored.index:06d}")
            instance_map = stored.frame.truth.instance_map
            height, width = instance_map.shape
            ignored = np.zeros((height, width), np.bool_)
            for each, counts in self.labels.seen(stored):
                mask = instance_map == each.instance_id
                if not counts:
                    ignored |= mask
                    continue
                kind = CLASSES.get(self.labels.names[each.class_number], OTHERS_FROM + each.class_number)
                if each.name not in identities:
                    few = used[kind] < IDS_OF_CLASS
                    check("data", few, f"at most {IDS_OF_CLASS} objects of a class in an episode", "more")
                    identities[each.name] = kind * IDS_OF_CLASS + used[kind]
                    used[kind] += 1
                rows.append(f"{stored.index} {identities[each.name]} {kind} {height} {width} {runs_of(mask)['counts']}")
            if ignored.any():
                region = f"{IGNORED * IDS_OF_CLASS} {IGNORED}"
                rows.append(f"{stored.index} {region} {height} {width} {runs_of(ignored)['counts']}")
        self.write_lines(f"label_02/{number}.txt", rows)
        self._sequences.append(f"{number},{episode.seed},{self.name_of(episode)}")
        self._ends.append(f"{number} empty 000000 {len(episode) - 1:06d}")

    def end(self) -> None:
        """Write the lists of sequences."""
        self.write_lines("sequences.csv", self._sequences)
        self.write_lines("evaluate_mots.seqmap.training", self._ends)
