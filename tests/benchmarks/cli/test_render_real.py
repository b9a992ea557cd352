"""``frameout render --real``: a video of a sequence, with its boxes; the overlay is that of ``track``."""

from __future__ import annotations

import re
from pathlib import Path

import av
import numpy as np
import pytest
from numpy.typing import NDArray

from benchmarks.cli import render
from benchmarks.cli.main import main
from benchmarks.run.jobs import Job
from benchmarks.show.video import marks
from benchmarks.show.video.episode_video import HEIGHT_PX as CAPTION_PX
from tests.benchmarks.data.written_sequences import AWAY, FRAMES, HEIGHT_PX, WIDTH_PX, true_boxes, write_otb


@pytest.fixture
def red_box(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return write_otb(tmp_path / "set" / "RedBox")


def pictures_of(path: str) -> list[NDArray[np.uint8]]:
    with av.open(path) as video:
        return [frame.to_ndarray(format="rgb24") for frame in video.decode(video=0)]


def test_a_sequence_is_drawn_with_its_boxes(red_box: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["render", "--real", str(red_box), "--tracker", "hold", "--scale", "2", "--out", "o.mp4"]) == 0
    assert capsys.readouterr().out == "o.mp4\n"
    pictures = pictures_of("o.mp4")
    assert len(pictures) == FRAMES
    zoom = pictures[0].shape[1] / (2 * WIDTH_PX)
    for k, box in enumerate(true_boxes()):
        view = pictures[k][:-CAPTION_PX].astype(int)
        is_blue = np.abs(view - marks.TRUTH).sum(axis=2) < 90
        if k in AWAY:
            assert not is_blue.any()
        else:
            # The estimate hides the corners.
            top = zoom * (np.array([0.5 * (box[0] + box[2]), box[1]]) + 0.5 * np.array([WIDTH_PX, HEIGHT_PX]))
            assert np.abs(np.argwhere(is_blue)[:, ::-1] - top).max(axis=1).min() < 4


def test_a_sequence_and_its_pictures_have_the_same_overlay(red_box: Path) -> None:
    """While the target is away no truth is drawn, so all pixels are equal but for the words and the codec's noise."""
    x_min, y_min, x_max, y_max = true_boxes()[0]
    box = f"{x_min},{y_min},{x_max - x_min},{y_max - y_min}"
    same = ["--tracker", "constant_velocity", "--scale", "2"]
    assert main(["render", "--real", str(red_box), *same, "--out", "rendered.mp4"]) == 0
    assert main(["track", str(red_box / "img"), "--box", box, *same, "--out", "tracked.mp4"]) == 0
    rendered, tracked = pictures_of("rendered.mp4"), pictures_of("tracked.mp4")
    assert len(rendered) == len(tracked) == FRAMES
    for k in AWAY:
        difference = rendered[k][:-CAPTION_PX].astype(int) - tracked[k][:-CAPTION_PX]
        assert np.abs(difference).mean() < 1.0
        assert np.quantile(np.abs(difference), 0.999) < 24


def test_of_several_sequences_one_is_named(red_box: Path, capsys: pytest.CaptureFixture[str]) -> None:
    write_otb(red_box.parent / "Another")
    assert main(["render", "--real", str(red_box.parent)]) == 2
    assert "sequence: expected one of Another, RedBox; got ''" in capsys.readouterr().err
    words = ["render", "--real", str(red_box.parent), "--sequence", "RedBox", "--frames", "2"]
    assert main(words) == 0
    assert capsys.readouterr().out == "results/RedBox.mp4\n"


@pytest.mark.parametrize("place", [["--real", "set/RedBox"], ["--preset", "quick"]])
def test_a_tracker_s_own_process_is_drawn_without_being_named_twice(
    red_box: Path, place: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    jobs: list[Job] = []
    monkeypatch.setattr(render, "render_episode", lambda job, out, **how: jobs.append(job) or [])
    assert main(["render", *place, "--process", "mine=true"]) == 0
    assert list(jobs[0].trackers) == ["mine"]
    assert main(["render", *place, "--process", "mine=true", "--tracker", "hold"]) == 0
    assert list(jobs[1].trackers) == ["hold"]


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["--real", "nix"], "real: expected folders that exist"),
        (["--sequence", "RedBox"], "sequence: expected none without --real, got 'RedBox'"),
        (["--layout", "otb"], "layout: expected none but with --real"),
        (["--real", "set/RedBox", "--controller", "centre"], "controller: expected none for a real sequence"),
        (["--real", "set/RedBox", "--link", "delayed"], "link: expected none for a real sequence"),
        (
            ["--real", "set/RedBox", "--seed", "4"],
            "seed: expected none for a real sequence, .*, got 4",
        ),
        (["harbour", "--real", "set/RedBox"], "scenario: expected none for a real sequence, .*, got 'harbour'"),
        (["--real", "set/RedBox", "--tracker", "nix"], "tracker: expected one of"),
    ],
)
def test_wrong_input_is_one_line(
    red_box: Path, words: list[str], told: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["render", *words]) == 2
    (line,) = [line for line in capsys.readouterr().err.splitlines() if not line.startswith("note: ")]
    assert re.match(f"error: {told}", line)
