"""``frameout export``: write a data set in the file layout of another benchmark."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

import tyro

from benchmarks.cli.arguments import FOLDER, ONE_NAME, WithModules
from benchmarks.contract.rows import ESTIMATES, FILE_NAME
from benchmarks.contract.text import counted
from benchmarks.run.packages import needs_data
from sim.checks import check


@dataclass(frozen=True)
class Export(WithModules):
    """Write a data set, or the answers of trackers, in a format that other programs read (pip install
    'frameout[data]').

    Formats: coco, coco-keypoints, davis, dota, hub, kitti-depth, kitti-flow, kitti-forward-flow, kitti-object,
    kitti-stereo, mot, mots, otb, rerun (pip install 'frameout[rerun]'), sintel-flow, tao-amodal, vot, webdataset, yolo,
    yolo-obb, yolo-seg, and those of `--modules`. Each says in the README.md that it writes where its axes begin, what
    its boxes enclose, and where the format is defined. Pictures stored as PNG or JPEG are copied, others become PNG.

    Of a folder of `frameout bench --keep-estimates` it writes what the trackers answered, in mot (for TrackEval) or vot
    (of one target; for the VOT toolkit); `frameout score` reads both.

    Attributes:
        directory: folder or URL of the data set, of all its parts if it has several, or folder of results.
        format: one of those above.
        out: the folder to write, or a URL such as s3://bucket/folder, new or empty. A folder appears whole or not at
            all; to a store README.md is sent last, and after a failure what was sent is removed.
        allow_incomplete: export what there is of a data set in which episodes are missing. Otherwise it is refused, as
            is one whose files are not those that were written.
        classes: class = car, person, boat, fish …; kind = the scene's own kinds: models of cars, parts of people in the
            script. Either has the same numbers for all data sets of a scene. Formats without classes have no choice.
        min_visible: least share (0 to 1) of an object's own pixels that is seen and shows no mirror image of a lamp.
            Objects below it are marked so that evaluation ignores them, where the format can say so (iscrowd in coco
            and hub, DontCare in kitti-object, difficult in dota, distractors in mot, ignored regions in mots); else
            they are left out.
        min_size: least shorter side of the box around what is seen, pixels; likewise.
        ignore_standing: what only stands about, parked cars and moored boats; likewise.
    """

    directory: Annotated[str, tyro.conf.Positional]
    format: Annotated[str, ONE_NAME]
    out: Annotated[str, FOLDER]
    allow_incomplete: bool = False
    classes: Literal["class", "kind"] = "class"
    min_visible: float = 0.0
    min_size: float = 0.0
    ignore_standing: bool = False
    resumes = False

    def run(self) -> int:
        """Write it; return the exit status."""
        needs_data()
        # After the check, since they import these packages.
        if (Path(self.directory) / ESTIMATES).is_dir():
            from benchmarks.data.predictions.writing import write_predictions

            for name in ("allow_incomplete", "classes", "min_visible", "min_size", "ignore_standing"):
                given, default = getattr(self, name), getattr(Export, name)
                check(name.replace("_", "-"), given == default, "none for the answers of trackers", given)
            print(f"{self.out}: {counted(write_predictions(Path(self.directory), self.format, self.out), 'file')}")
            return 0
        without = (Path(self.directory) / FILE_NAME).is_file()
        wanted = "a data set, or results of `frameout bench --keep-estimates`"
        check("directory", not without, wanted, "results without the trackers' answers")
        from benchmarks.cli.data_functions import export

        left_out = export(
            self.directory,
            self.format,
            self.out,
            allow_incomplete=self.allow_incomplete,
            classes=self.classes,
            min_visible=self.min_visible,
            min_size_px=self.min_size,
            ignore_standing=self.ignore_standing,
        )
        print(self.out)
        if left_out:
            print(f"{counted(left_out, 'object')} of single pictures left out or marked as ignored")
        return 0
