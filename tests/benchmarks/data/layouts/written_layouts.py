"""Small data sets on disk, each by the written rules of its layout: the same target, with all that it can tell.

On eight pictures it is in the picture, hidden, outside for two, cut by the border, hidden in part, and seen again.
"""

from __future__ import annotations

import json
import shutil
import tarfile
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pycocotools.mask as coco_masks
from numpy.typing import NDArray
from PIL import Image

from tests.benchmarks.data.written_sequences import HEIGHT_PX, WIDTH_PX, write_lines, write_pictures

SEEN_XYXY = np.array(
    [
        [10.0, 20.0, 22.0, 28.0],
        [16.0, 20.0, 28.0, 28.0],
        [np.nan] * 4,
        [np.nan] * 4,
        [np.nan] * 4,
        [58.0, 20.0, 70.0, 28.0],
        [40.0, 20.0, 52.0, 28.0],
        [34.0, 20.0, 46.0, 28.0],
    ]
)
"""(8, 4) boxes of the whole target where it is seen."""
CLIPPED_XYXY = np.clip(SEEN_XYXY, 0, (WIDTH_PX, HEIGHT_PX, WIDTH_PX, HEIGHT_PX))
"""(8, 4) likewise, only as far as the border."""
HIDDEN, OUTSIDE, CUT, PARTLY = (2,), (3, 4), (5,), (6,)
STATES = ("in", "in", "occluded", "out", "out", "partial", "occluded", "in")
"""What the most talkative layout tells."""
FRAMES = len(SEEN_XYXY)


def xywh(box: Sequence[float] | NDArray[np.float64], first: float = 0.0) -> list[float]:
    """Return left, top, width, height of a box, where the top left corner of the picture is at (first, first)."""
    return [float(box[0] + first), float(box[1] + first), float(box[2] - box[0]), float(box[3] - box[1])]


def line(box: NDArray[np.float64], first: float, none: str = "nan,nan,nan,nan") -> str:
    """Return a box as text, ``none`` for none."""
    return none if np.isnan(box).any() else ",".join(f"{number:g}" for number in xywh(box, first))


def flags(frames: Sequence[int]) -> list[str]:
    """Return 1 for the frames and 0 for the others."""
    return [f"{k in frames:d}" for k in range(FRAMES)]


def write_lasot(root: Path) -> Path:
    """Boxes where the target is absent are arbitrary; flags stand in one line."""
    folder = root / "car" / "car-7"
    write_pictures(folder / "img", list(SEEN_XYXY), "{:08d}.jpg")
    write_lines(folder / "groundtruth.txt", [line(box, 1.0, "1,1,-1,-1") for box in CLIPPED_XYXY])
    write_lines(folder / "full_occlusion.txt", [",".join(flags(HIDDEN))])
    write_lines(folder / "out_of_view.txt", [",".join(flags(OUTSIDE))])
    write_lines(folder / "nlp.txt", ["a red car, on a road"])
    return root


def write_got10k(root: Path) -> Path:
    """Cover 0 is nothing seen, 8 all; an absent target has cover 0 as well."""
    folder = root / "val" / "GOT-10k_Val_000001"
    write_pictures(folder, list(SEEN_XYXY), "{:08d}.jpg")
    write_lines(folder / "groundtruth.txt", [line(box, 1.0, "0,0,0,0") for box in CLIPPED_XYXY])
    write_lines(folder / "absence.label", flags(OUTSIDE))
    cover = {HIDDEN[0]: 0, OUTSIDE[0]: 0, OUTSIDE[1]: 0, CUT[0]: 4, PARTLY[0]: 3}
    write_lines(folder / "cover.label", [f"{cover.get(k, 8)}" for k in range(FRAMES)])
    write_lines(folder / "cut_by_image.label", flags(CUT))
    meta = ["[METAINFO]", "url: https://youtu.be/x=1", "begin: 00:00:24", "anno_fps: 10Hz", "resolution: (64, 48)"]
    write_lines(folder / "meta_info.ini", meta)
    write_lines(root / "val" / "list.txt", [folder.name])
    return root


def write_trackingnet(root: Path) -> Path:
    """Every picture has a box; nothing is said of absences."""
    boxes = np.where(np.isnan(CLIPPED_XYXY), CLIPPED_XYXY[1], CLIPPED_XYXY)
    write_pictures(root / "TRAIN_3" / "frames" / "abc_0", list(boxes), "{}.jpg", first=0)
    write_lines(root / "TRAIN_3" / "anno" / "abc_0.txt", [line(box, 0.0) for box in boxes])
    (root / "TEST" / "anno").mkdir(parents=True)
    return root


def write_vot(root: Path) -> Path:
    """A rectangle, a polygon, a mask, and codes where there is no target."""
    folder = root / "car1"
    write_pictures(folder / "color", list(SEEN_XYXY), "{:08d}.jpg")
    regions = [line(box, 0.0, "0") for box in SEEN_XYXY]
    regions[1] = "16,20,28,20,28,28,16,28"
    regions[7] = f"m34,20,12,8,0,{12 * 8}"
    write_lines(folder / "groundtruth.txt", regions)
    write_lines(folder / "out_of_view.tag", flags(OUTSIDE))
    write_lines(folder / "occlusion.tag", flags((*HIDDEN, *PARTLY))[:7])
    write_lines(folder / "camera_motion.tag", flags(range(FRAMES)))
    write_lines(folder / "size.value", ["0.5"] * FRAMES)
    write_lines(folder / "sequence", ["channels.color=color/%08d.jpg", "format=default", "fps=25", "name=car1"])
    write_lines(root / "list.txt", ["car1"])
    return root


def write_mot(root: Path) -> Path:
    """The box of a hidden target stays, with visibility 0; a row that does not count is another's."""
    folder = root / "train" / "MOT17-02-FRCNN"
    write_pictures(folder / "img1", list(SEEN_XYXY), "{:06d}.jpg")
    rows = []
    for k, box in enumerate(SEEN_XYXY):
        seen = {HIDDEN[0]: 0.0, CUT[0]: 0.5, PARTLY[0]: 0.3}.get(k, 1.0)
        shown = [22.0, 20.0, 34.0, 28.0] if k in HIDDEN else box
        if k not in OUTSIDE:
            rows.append(f"{k + 1},7,{','.join(f'{number:g}' for number in xywh(shown, 1.0))},1,1,{seen:g}")
        rows.append(f"{k + 1},2,1,1,4,4,0,7,1")
    write_lines(folder / "gt" / "gt.txt", sorted(rows, key=lambda row: row.split(",")[1]))
    info = ["name=MOT17-02-FRCNN", "imDir=img1", "frameRate=14", f"seqLength={FRAMES}", "imExt=.jpg"]
    write_lines(folder / "seqinfo.ini", ["; by hand", "[Sequence]", *info])
    return root


def write_kitti(root: Path) -> Path:
    """Picture 1 is missing; the corner of the picture is at -0.5, -0.5; a region that is not cared for."""
    folder = root / "training"
    write_pictures(folder / "image_02" / "0001", list(SEEN_XYXY), "{:06d}.png", first=0)
    (folder / "image_02" / "0001" / "000001.png").unlink()
    rows = []
    for k, box in enumerate(CLIPPED_XYXY):
        rest = "-1 -1 -1 -1000 -1000 -1000 -10"
        if not np.isnan(box).any():
            truncated, occluded = int(k in CUT), 2 * int(k in PARTLY)
            numbers = " ".join(f"{number - 0.5:.6f}" for number in box)
            rows.append(f"{k} 7 Car {truncated} {occluded} -1.57 {numbers} {rest}")
        rows.append(f"{k} -1 DontCare -1 -1 -10 1.0 1.0 9.0 9.0 {rest}")
    write_lines(folder / "label_02" / "0001.txt", rows)
    return root


def write_oxuva(root: Path) -> Path:
    """Every other picture is labelled, as absent or present in shares of the picture; pictures before and after."""
    pictures = root / "images" / "dev" / "vid0042"
    write_pictures(pictures, [SEEN_XYXY[0], *SEEN_XYXY, SEEN_XYXY[0]], "{:06d}.jpeg", first=89)
    rows = []
    for k in range(0, FRAMES, 2):
        x_min, y_min, x_max, y_max = np.nan_to_num(CLIPPED_XYXY[k]) / (WIDTH_PX, HEIGHT_PX, WIDTH_PX, HEIGHT_PX)
        presence = "absent" if np.isnan(SEEN_XYXY[k]).any() else "present"
        numbers = ",".join(f"{number!r}" for number in map(float, (x_min, x_max, y_min, y_max)))
        rows.append(f"vid0042,obj0001,2,car,unknown,false,{90 + k},{presence},{numbers}")
    write_lines(root / "annotations" / "dev.csv", rows)
    return root


def write_tao(root: Path) -> Path:
    """Every other picture is labelled; a track has an annotation where it is seen."""
    pictures = root / "frames" / "val" / "YFCC100M" / "v_25685519b728afd746dfd1b2fe77c"
    write_pictures(pictures, list(SEEN_XYXY), "frame{:04d}.jpg")
    name = pictures.relative_to(root / "frames").as_posix()
    images = [
        {"id": 40 + k, "video_id": 5, "file_name": f"{name}/frame{k + 1:04d}.jpg", "frame_index": k}
        for k in range(0, FRAMES, 2)
    ]
    annotations = [
        {"id": k, "image_id": 40 + k, "track_id": 7, "category_id": 1, "bbox": xywh(CLIPPED_XYXY[k]), "area": 96}
        for k in range(0, FRAMES, 2)
        if not np.isnan(SEEN_XYXY[k]).any()
    ]
    content: dict[str, Any] = {"videos": [{"id": 5, "name": name, "width": WIDTH_PX, "height": HEIGHT_PX}]}
    content |= {"images": images, "annotations": annotations, "tracks": [{"id": 7, "category_id": 1, "video_id": 5}]}
    (root / "annotations").mkdir(parents=True)
    (root / "annotations" / "validation.json").write_text(json.dumps(content))
    return root


def write_tao_amodal(root: Path) -> Path:
    """Every picture has an annotation, with the box of the whole target and how much of it is seen."""
    pictures = root / "frames" / "validation" / "town"
    write_pictures(pictures, list(SEEN_XYXY), "frame{:06d}.png", first=0)
    whole = np.array(SEEN_XYXY)
    whole[HIDDEN[0]], whole[OUTSIDE[0]], whole[OUTSIDE[1]] = [22, 20, 34, 28], [64, 20, 76, 28], [70, 20, 82, 28]
    images, annotations = [], []
    for k, box in enumerate(whole):
        seen = not np.isnan(SEEN_XYXY[k]).any()
        images.append({"id": k + 1, "video_id": 1, "file_name": f"validation/town/frame{k:06d}.png", "frame_index": k})
        annotation = {"id": k + 1, "image_id": k + 1, "track_id": 7, "category_id": 1, "amodal_bbox": xywh(box)}
        annotation |= {"bbox": xywh(CLIPPED_XYXY[k]) if seen else [0, 0, 0, 0], "amodal_is_uncertain": False}
        annotation |= {"visibility": {CUT[0]: 0.5, PARTLY[0]: 0.3}.get(k, 1.0) if seen else 0.0}
        annotations.append(annotation | {"attributes": {"name": "target"}})
    video = {"id": 1, "name": "validation/town", "metadata": {"fps": 7.5}}
    (root / "amodal_annotations").mkdir(parents=True)
    content = {"videos": [video], "images": images, "annotations": annotations, "tracks": []}
    for name in ("validation.json", "validation_lvis_v1.json"):
        (root / "amodal_annotations" / name).write_text(json.dumps(content))
    return root


def write_coco(root: Path) -> Path:
    """A target is known by its name."""
    write_pictures(root / "images" / "town-000003", list(SEEN_XYXY), "{:06d}.png", first=0)
    images = [{"id": k + 1, "file_name": f"town-000003/{k:06d}.png"} for k in range(FRAMES)]
    annotations = [
        {"id": k + 1, "image_id": k + 1, "category_id": 1, "bbox": xywh(box), "attributes": {"name": "target"}}
        for k, box in enumerate(CLIPPED_XYXY)
        if not np.isnan(box).any()
    ]
    (root / "annotations").mkdir(parents=True)
    content = {"images": images, "annotations": annotations, "categories": [{"id": 1, "name": "car"}]}
    (root / "annotations" / "instances.json").write_text(json.dumps(content))
    return root


def write_yolo(root: Path) -> Path:
    """A text file for each picture, empty without an object; the sidecar says whose a line is."""
    write_pictures(root / "images" / "val", list(SEEN_XYXY), "town_{:06d}.png", first=0)
    rows = ["file,line,class,name"]
    for k, box in enumerate(CLIPPED_XYXY):
        place, lines = f"labels/val/town_{k:06d}.txt", ["1 0.5 0.5 0.25 0.25"]
        rows.append(f"{place},1,bus,bus-1")
        if not np.isnan(box).any():
            x_min, y_min, x_max, y_max = box / (WIDTH_PX, HEIGHT_PX, WIDTH_PX, HEIGHT_PX)
            numbers = map(float, (0.5 * (x_min + x_max), 0.5 * (y_min + y_max), x_max - x_min, y_max - y_min))
            lines.append(f"0 {' '.join(map(repr, numbers))}")
            rows.append(f"{place},2,car,target")
        write_lines(root / place, lines)
    write_lines(root / "objects.csv", rows)
    return root


def write_webdataset(root: Path) -> Path:
    """Two tar files, between which a sequence may be cut; what there is none of has a number of its own."""
    write_pictures(root / "loose", list(SEEN_XYXY), "town-000003_{:06d}.png", first=0)
    states = ("in", "in", "occluded", "out", "out", "partial", "occluded", "in")
    for part, frames in enumerate((range(5), range(5, FRAMES))):
        with tarfile.open(root / f"town-train-{part:05d}.tar", "w") as tar:
            for k in frames:
                picture = root / "loose" / f"town-000003_{k:06d}.png"
                none = [-1e9] * 4
                seen = not np.isnan(SEEN_XYXY[k]).any()
                car = {"names": "target", "state": states[k], "box_xyxy": [*SEEN_XYXY[k]] if seen else none}
                car |= {"visible_box_xyxy": [*CLIPPED_XYXY[k]] if seen else none}
                content = {"time_s": k / 12.5, "objects": [car]}
                tar.add(picture, picture.name)
                (root / "loose" / "truth.json").write_text(json.dumps(content))
                tar.add(root / "loose" / "truth.json", f"{picture.stem}.json")
    shutil.rmtree(root / "loose")
    return root


def write_mots(root: Path) -> Path:
    """Masks as run lengths of COCO; class 10 is what is not annotated."""
    write_pictures(root / "training" / "image_02" / "0002", list(SEEN_XYXY), "{:06d}.png", first=0)
    rows = []
    for k in range(FRAMES):
        if not np.isnan(SEEN_XYXY[k]).any():
            rows.append(f"{k} 1007 1 {HEIGHT_PX} {WIDTH_PX} {counts(number_map(k, 1))}")
        rows.append(f"{k} 10000 10 {HEIGHT_PX} {WIDTH_PX} {counts(~number_map(k, 1).astype(bool))}")
    write_lines(root / "instances_txt" / "0002.txt", rows)
    return root


def write_davis(root: Path) -> Path:
    """Indexed masks of every other picture, as of YouTube-VOS every fifth; 255 does not count."""
    write_pictures(root / "JPEGImages" / "480p" / "car", list(SEEN_XYXY), "{:05d}.jpg", first=0)
    for k in range(0, FRAMES, 2):
        mask = number_map(k, 7)
        mask[:2] = 255
        image = Image.fromarray(mask)
        image.putpalette([number % 256 for number in range(768)])
        place = root / "Annotations" / "480p" / "car" / f"{k:05d}.png"
        place.parent.mkdir(parents=True, exist_ok=True)
        image.save(place)
    return root


def number_map(k: int, number: int) -> NDArray[np.uint8]:
    """Return the map (H, W) of a picture, with a number where the target is seen."""
    found = np.zeros((HEIGHT_PX, WIDTH_PX), np.uint8)
    x_min, y_min, x_max, y_max = np.nan_to_num(CLIPPED_XYXY[k]).astype(int)
    found[y_min:y_max, x_min:x_max] = number
    return found


def counts(mask: NDArray[Any]) -> str:
    """Return a mask as COCO's run lengths, by its own program."""
    code: bytes = coco_masks.encode(np.asfortranarray(mask, np.uint8))["counts"]
    return code.decode("ascii")


LAYOUTS: dict[str, tuple[Callable[[Path], Path], str]] = {
    "lasot": (write_lasot, "car-7"),
    "got10k": (write_got10k, "GOT-10k_Val_000001"),
    "trackingnet": (write_trackingnet, "abc_0"),
    "vot": (write_vot, "car1"),
    "mot": (write_mot, "MOT17-02-FRCNN-7"),
    "kitti": (write_kitti, "0001-7"),
    "oxuva": (write_oxuva, "vid0042-obj0001"),
    "tao": (write_tao, "v_25685519b728afd746dfd1b2fe77c-7"),
    "coco": (write_coco, "town-000003-target"),
    "yolo": (write_yolo, "town-bus-1"),
    "mots": (write_mots, "0002-1007"),
    "davis": (write_davis, "car-7"),
    "webdataset": (write_webdataset, "town-000003-target"),
}
"""Name → what writes a data set, and the name of its sequence."""
