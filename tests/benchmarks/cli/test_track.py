"""``frameout track``: one command from a video to an overlay; wrong input is one line."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import av
import numpy as np
import pytest
from numpy.typing import NDArray

from benchmarks.cli.main import main
from benchmarks.data.footage.screen import Screen
from benchmarks.data.mot_text import read_mot
from tests.benchmarks.data.footage.written_footage import FIRST_BOX, FRAMES, picture_of, write_sound, write_video

ROOT = Path(__file__).parents[3]


@pytest.fixture
def clip(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    monkeypatch.chdir(tmp_path)
    return write_video(Path("clip.mp4")).name


def test_a_video_becomes_an_overlay_and_estimates(clip: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["track", clip, "--tracker", "hold", "--box", FIRST_BOX, "--estimates", "e.txt"]) == 0
    out, err = capsys.readouterr()
    assert out == f"results/clip-hold.mp4 ({FRAMES} pictures)\ne.txt\n"
    assert "error" not in err
    with av.open("results/clip-hold.mp4") as video:
        assert len(list(video.decode(video=0))) == FRAMES
    assert len(read_mot(Path("e.txt")).frame) == FRAMES


def test_notes_about_the_footage_are_told(clip: str, capsys: pytest.CaptureFixture[str]) -> None:
    path = write_video(Path("hdr.mp4"), pixels="yuv420p10le", color_trc=16)
    assert main(["track", str(path), "--tracker", "hold", "--box", FIRST_BOX]) == 0
    assert "note: hdr.mp4 has high dynamic range (PQ)" in capsys.readouterr().err


@pytest.mark.parametrize(("box", "beyond"), [("100,20,134,40", "74"), ("-9,20,30,30", "9"), ("100,20,60.4,100", "")])
def test_a_box_beyond_the_picture_is_told(box: str, beyond: str, clip: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["track", clip, "--tracker", "hold", f"--box={box}", "--frames", "2"]) == 0
    notes = [line for line in capsys.readouterr().err.splitlines() if "beyond" in line]
    told = f"note: the box reaches {beyond} px beyond the picture; it is left,top,width,height"
    assert notes == ([told] if beyond else [])


GOOD = f"clip.mp4 --tracker hold --box {FIRST_BOX}"


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (f"none.mp4 --tracker hold --box {FIRST_BOX}", "video: expected one that can be opened, got 'none.mp4'"),
        (f"sound.m4a --tracker hold --box {FIRST_BOX}", "video: expected a stream of pictures, .* with audio"),
        ("clip.mp4", "tracker: expected a name, by --tracker or --process, got none"),
        (f"clip.mp4 --tracker nix --box {FIRST_BOX}", "tracker: expected one of .*; got 'nix'"),
        (f"clip.mp4 --tracker blind_ahead --box {FIRST_BOX}", "tracker: expected one that sees pictures, got 'blind_a"),
        (f"clip.mp4 --process a=nix --box {FIRST_BOX}", "process a: expected a program.*, got 'nix'"),
        ("clip.mp4 --tracker hold", "box: expected one of --box X,Y,W,H, --pick and --detect, as hold follows one"),
        (f"{GOOD} --detect", "box: expected one of .*, got 2 of them"),
        ("clip.mp4 --tracker hold --box 1,1,9", "box: expected left,top,width,height in pixels.*'1,1,9'"),
        ("clip.mp4 --tracker hold --box 1,1,0,9", "box: expected left,top,width,height in pixels"),
        ("clip.mp4 --tracker hold --box 1,1,inf,9", "box: expected left,top,width,height in pixels"),
        ("clip.mp4 --tracker hold --box 999,1,9,9", "box: expected one that meets the picture of 160 x 120 pixels"),
        (f"{GOOD} --out x.avi", "out: expected a file that ends in .mp4"),
        (f"{GOOD} --out clip.mp4", "out: expected another file than the video"),
        (f"{GOOD} --estimates e.xls", "estimates: expected a file that ends in .txt, .csv, .parquet"),
        (f"{GOOD} --scale 0.5", "scale: expected a number from 1 to 4"),
        (f"{GOOD} --frames 0", "frames: expected a whole number >= 1"),
        (f"{GOOD} --limit-s 0", "limit_s: expected a number of seconds"),
        (f"{GOOD} --rate-hz 9", "rate_hz: expected none but for a folder"),
    ],
)
def test_wrong_input_is_one_line(words: str, told: str, clip: str, capsys: pytest.CaptureFixture[str]) -> None:
    write_sound(Path("sound.m4a"))
    before = sorted(Path().rglob("*.*"))
    assert main(["track", *words.split()]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert re.fullmatch(rf"error: {told}.*\n", err), err
    assert [each for each in sorted(Path().rglob("*.*")) if each not in before] == []


def test_without_a_screen_that_is_one_line(
    clip: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("pygame")
    for name in ("DISPLAY", "WAYLAND_DISPLAY", "SDL_VIDEODRIVER"):
        monkeypatch.delenv(name, raising=False)
    for words in (["--pick"], ["--box", FIRST_BOX, "--show"]):
        assert main(["track", clip, "--tracker", "hold", *words]) == 2
        assert re.fullmatch(r"error: (pick|show): expected a screen to open a window on .*\n", capsys.readouterr().err)


def test_a_box_is_dragged_in_a_window(
    clip: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    pygame = pytest.importorskip("pygame")
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")
    picked: list[NDArray[np.float64] | None] = []
    ask = Screen.box_on

    def dragged(self: Screen, image_rgb: NDArray[np.uint8]) -> NDArray[np.float64] | None:
        self.show(image_rgb)
        slip = [(pygame.MOUSEBUTTONDOWN, (50, 50)), (pygame.MOUSEBUTTONUP, (51, 50))]
        drag = [(pygame.MOUSEBUTTONDOWN, (36, 56)), (pygame.MOUSEMOTION, (30, 50)), (pygame.MOUSEBUTTONUP, (20, 40))]
        monkeypatch.setattr(self, "show", lambda image_rgb: True)  # It would take the events that follow.
        for kind, place in slip + drag:
            more = {"rel": (0, 0), "buttons": (1, 0, 0)} if kind == pygame.MOUSEMOTION else {"button": 1}
            pygame.event.post(pygame.event.Event(kind, pos=place, **more))
        picked.append(ask(self, image_rgb))
        return picked[0]

    monkeypatch.setattr(Screen, "box_on", dragged)
    assert main(["track", clip, "--tracker", "hold", "--pick", "--frames", "2"]) == 0
    np.testing.assert_allclose(picked, [[20, 40, 36, 56]])


def test_escape_ends_a_window(clip: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    pygame = pytest.importorskip("pygame")
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")
    show = Screen.show

    def escaped(self: Screen, image_rgb: NDArray[np.uint8]) -> bool:
        show(self, image_rgb)
        pygame.event.post(pygame.event.Event(pygame.KEYDOWN, key=pygame.K_ESCAPE))
        return show(self, image_rgb)

    monkeypatch.setattr(Screen, "show", escaped)
    assert main(["track", clip, "--tracker", "hold", "--box", FIRST_BOX, "--show"]) == 130
    out, err = capsys.readouterr()
    assert out == "results/clip-hold.mp4 (1 picture)\n"
    assert err.endswith("stopped\n")
    assert Path("results/clip-hold.mp4").is_file()


OWN = """
from trackers.registry import NoParameters, register
from trackers.types import Estimate


@register("fails_late", role="external", summary="raises on picture 5")
class FailsLate:
    Parameters = NoParameters

    def __init__(self, parameters, rng):
        self.count = 0

    def initialise(self, observation, box_xyxy):
        self.place = (box_xyxy[:2] + box_xyxy[2:]) / 2

    def update(self, observation):
        self.count += 1
        return Estimate(self.place if self.count < 5 else self.nothing)
"""


def test_an_own_tracker_that_fails_is_named_with_its_line(
    clip: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    from trackers import registry

    monkeypatch.setattr(registry, "_ENTRIES", registry.entries())
    monkeypatch.setattr(sys, "path", list(sys.path))
    Path("fails_late.py").write_text(OWN)
    words = ["--modules", "fails_late.py", "--tracker", "fails_late", "--box", FIRST_BOX]
    assert main(["track", clip, *words]) == 1
    out, err = capsys.readouterr()
    assert out == "results/clip-fails_late.mp4 (6 pictures)\n"
    (line,) = [line for line in err.splitlines() if line.startswith("error")]
    assert line.startswith("error: fails_late failed on frame 5 of clip.mp4: AttributeError: ")
    assert "(fails_late.py, line 18)" in line
    sys.modules.pop("fails_late", None)


@pytest.mark.heavy
def test_ctrl_c_leaves_a_playable_file_and_the_estimates_so_far(tmp_path: Path) -> None:
    pictures = [picture_of(k % 20) for k in range(3000)]
    path = write_video(tmp_path / "long.mkv", pictures, codec="ffv1", pixels="bgr0")
    words = ["track", str(path), "--tracker", "hold", "--box", FIRST_BOX, "--out", "o.mp4", "--estimates", "e.csv"]
    run = subprocess.Popen(
        [sys.executable, "-m", "benchmarks.cli.main", *words],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    part = tmp_path / "o.mp4.part"
    until = time.monotonic() + 120
    while not (part.is_file() and part.stat().st_size > 0) and time.monotonic() < until:
        time.sleep(0.05)
    time.sleep(1.0)
    run.send_signal(signal.SIGINT)
    out, err = run.communicate(timeout=60)
    assert run.returncode == 130, err
    assert err.endswith("stopped\n")
    with av.open(str(tmp_path / "o.mp4")) as video:
        count = len(list(video.decode(video=0)))
    assert 0 < count < 3000
    assert out == f"o.mp4 ({count} pictures)\ne.csv\n"
    assert len((tmp_path / "e.csv").read_text().splitlines()) == count + 1
    assert not part.exists()
