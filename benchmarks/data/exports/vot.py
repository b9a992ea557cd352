"""VOT: sequences of one target, as the VOT toolkit reads them (https://votchallenge.github.io/toolkit/)."""

from __future__ import annotations

from pathlib import Path

from benchmarks.data.exports.frames import picture_ending, sequence_name
from benchmarks.data.exports.single_target import TargetRow, single_target_format, write_sequence
from benchmarks.data.sets.data_set import DataSet
from benchmarks.data.sets.stored_episode import StoredEpisode

NOTE = """
Format: the VOT toolkit's own, https://votchallenge.github.io/toolkit/. `list.txt` names the sequences; each holds
`sequence` (properties), `color/` (pictures from 1), `groundtruth.txt` and the tags `out_of_view.tag`, `occlusion.tag`,
a line a picture. `fps` is a whole number, as the toolkit wants it, `exact_fps` the true one. The top left corner of the
picture is 0, 0. The toolkit reads NaN as "no target here".
"""


def _write_episode(data: DataSet, episode: StoredEpisode, folder: Path) -> str:
    sequence = folder / sequence_name(data, episode.seed)
    rows: list[TargetRow] = []
    last = write_sequence(data, episode, sequence / "color", "{:08d}", rows.append)
    lines = {
        "groundtruth.txt": [row.box_text(0.0) for row in rows],
        "out_of_view.tag": [f"{row.is_out:d}" for row in rows],
        "occlusion.tag": [f"{row.is_occluded:d}" for row in rows],
        "sequence": [
            f"name={sequence.name}",
            # The toolkit takes whole numbers only.
            f"fps={max(1, round(episode.rate_hz))}",
            f"exact_fps={episode.rate_hz:g}",
            "format=default",
            "channel.default=color",
            f"channels.color=color/%08d.{picture_ending(data)}",
            f"width={last.camera.width_px}",
            f"height={last.camera.height_px}",
            f"length={len(episode)}",
        ],
    }
    for name, content in lines.items():
        (sequence / name).write_text("".join(f"{line}\n" for line in content), encoding="utf-8")
    return sequence.name


VOT = single_target_format("one target, as the VOT toolkit reads it, with tags for out of view", NOTE, _write_episode)
