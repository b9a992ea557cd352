"""OTB: sequences of one target (Wu, Lim, Yang 2015, https://doi.org/10.1109/TPAMI.2014.2388226)."""

from __future__ import annotations

from pathlib import Path

from benchmarks.data.exports.frames import sequence_name
from benchmarks.data.exports.single_target import TargetRow, single_target_format, write_sequence
from benchmarks.data.sets.data_set import DataSet
from benchmarks.data.sets.stored_episode import StoredEpisode

NOTE = """
Format: OTB (Wu, Lim, Yang 2015, http://cvlab.hanyang.ac.kr/tracker_benchmark/). `list.txt` names the sequences; each
holds `img/` (pictures from 1), `groundtruth_rect.txt`, and `out_of_view.txt` and `occlusion.txt`, a line a picture. The
top left corner of the picture is 1, 1. OTB itself has a box in every picture; a line of NaN means, as in UAV123, that
the target is not seen.
"""


def _write_episode(data: DataSet, episode: StoredEpisode, folder: Path) -> str:
    sequence = folder / sequence_name(data, episode.seed)
    rows: list[TargetRow] = []
    write_sequence(data, episode, sequence / "img", "{:04d}", rows.append)
    lines = {
        "groundtruth_rect.txt": [row.box_text(1.0) for row in rows],
        "out_of_view.txt": [f"{row.is_out:d}" for row in rows],
        "occlusion.txt": [f"{row.is_occluded:d}" for row in rows],
    }
    for name, content in lines.items():
        (sequence / name).write_text("".join(f"{line}\n" for line in content), encoding="utf-8")
    return sequence.name


OTB = single_target_format("one target, in the layout of OTB", NOTE, _write_episode)
