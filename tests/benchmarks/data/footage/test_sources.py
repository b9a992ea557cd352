"""Footage of many kinds is read as a player shows it; what is none is refused in one line."""

from __future__ import annotations

import itertools
import re
import socket
import threading
import time
import tracemalloc
from pathlib import Path

import av
import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from benchmarks.data.footage.sources import Camera, Footage, Live, Picture, open_footage
from tests.benchmarks.data.footage.written_footage import (
    FRAMES,
    HEIGHT_PX,
    SIDE_PX,
    WIDTH_PX,
    corner_of,
    picture_of,
    turned,
    write_sound,
    write_video,
)


def read(source: Path | str) -> tuple[list[Picture], Footage]:
    footage = open_footage(str(source))
    pictures = list(footage.pictures())
    footage.close()
    return pictures, footage


def red_corner(image: NDArray[np.uint8]) -> tuple[int, int]:
    """Return the top left corner x, y of what is red."""
    rgb = image.astype(int)
    rows, columns = np.nonzero(rgb[..., 0] - rgb[..., 1:].max(axis=2) > 90)
    return int(columns.min()), int(rows.min())


@pytest.mark.parametrize(
    ("name", "codec", "pixels"),
    [
        ("a.mp4", "libx264", "yuv420p"),
        ("ten_bit.mp4", "libx264", "yuv420p10le"),
        ("lossless.mkv", "ffv1", "bgr0"),
        ("sixteen_bit.mkv", "ffv1", "gbrp16le"),
        ("alpha.webm", "libvpx-vp9", "yuva420p"),
        ("intra.mov", "prores_ks", "yuv422p10le"),
        ("old.mp4", "mpeg4", "yuv420p"),
        ("stream.ts", "libx264", "yuv420p"),
    ],
)
def test_pixel_formats_and_containers_are_read(tmp_path: Path, name: str, codec: str, pixels: str) -> None:
    pictures, footage = read(write_video(tmp_path / name, codec=codec, pixels=pixels))
    assert len(pictures) == FRAMES
    assert not footage.notes
    for k, picture in enumerate(pictures):
        assert picture.image_rgb.shape == (HEIGHT_PX, WIDTH_PX, 3)
        assert picture.image_rgb.dtype == np.uint8
        assert np.abs(np.subtract(red_corner(picture.image_rgb), corner_of(k))).max() <= 2
    np.testing.assert_allclose([p.time_s - pictures[0].time_s for p in pictures], np.arange(FRAMES) / 30, atol=2e-3)


@pytest.mark.parametrize("pixels", ["gray", "gray10le", "gray16le"])
def test_grey_pictures_have_three_equal_channels(tmp_path: Path, pixels: str) -> None:
    pictures, _ = read(write_video(tmp_path / "grey.mkv", codec="ffv1", pixels=pixels))
    expected = cv2.cvtColor(picture_of(3), cv2.COLOR_RGB2GRAY).astype(int)
    seen = pictures[3].image_rgb.astype(int)
    assert (np.ptp(seen, axis=2) <= 1).all()
    assert np.abs(seen[..., 0] - expected).max() <= 3


@pytest.mark.parametrize(("width", "height"), [(161, 121), (33, 35), (32, 240)])
def test_odd_sizes_are_read(tmp_path: Path, width: int, height: int) -> None:
    pictures = [picture_of(k, size=(width, height)) for k in range(3)]
    (first, *_), _ = read(write_video(tmp_path / "odd.mkv", pictures, codec="ffv1", pixels="bgr0"))
    np.testing.assert_array_equal(first.image_rgb, pictures[0])


@pytest.mark.parametrize(
    ("matrix", "shown"),
    [
        ((0, 1, -1, 0), lambda image: np.rot90(image, -1)),
        ((-1, 0, 0, -1), lambda image: np.rot90(image, 2)),
        ((0, -1, 1, 0), lambda image: np.rot90(image, 1)),
        ((-1, 0, 0, 1), lambda image: image[:, ::-1]),
        ((1, 0, 0, -1), lambda image: image[::-1]),
        ((0, 1, 1, 0), lambda image: image.transpose(1, 0, 2)),
    ],
)
def test_pictures_are_turned_as_the_phone_says(
    tmp_path: Path, matrix: tuple[int, int, int, int], shown: object
) -> None:
    """A point (x, y) of the stored picture is shown at (a x + c y, b x + d y), shifted: that is what a player does."""
    plain = write_video(tmp_path / "plain.mp4")
    upright = read(plain)[0][4].image_rgb
    picture = read(turned(plain, matrix))[0][4].image_rgb
    np.testing.assert_array_equal(picture, shown(upright))
    a, b, c, d = matrix
    corners = np.array([(0, 0), (WIDTH_PX, 0), (0, HEIGHT_PX), (WIDTH_PX, HEIGHT_PX)])
    x, y = corner_of(4)
    square = np.array([(x, y), (x + SIDE_PX, y + SIDE_PX)])
    turn = np.array([[a, c], [b, d]])
    placed = square @ turn.T - (corners @ turn.T).min(axis=0)
    assert np.abs(placed.min(axis=0) - red_corner(picture)).max() <= 1


def test_times_of_a_variable_rate_are_those_of_the_pictures(tmp_path: Path) -> None:
    times_s = [0.0, 0.033, 0.1, 0.5, 0.55, 1.2]
    pictures, _ = read(write_video(tmp_path / "v.mp4", [picture_of(k) for k in range(6)], times_s=times_s))
    np.testing.assert_allclose([each.time_s for each in pictures], times_s, atol=1e-3)


def test_a_raw_stream_without_times_has_those_of_its_rate(tmp_path: Path) -> None:
    pictures, footage = read(write_video(tmp_path / "raw.h264"))
    assert len(pictures) == FRAMES
    steps_s = np.diff([each.time_s for each in pictures])
    np.testing.assert_allclose(steps_s, 1 / footage.rate_hz)


def test_wide_pixels_are_made_square(tmp_path: Path) -> None:
    path = write_video(tmp_path / "wide.mp4", sample_aspect_ratio=2)
    assert read(path)[0][0].image_rgb.shape == (HEIGHT_PX, 2 * WIDTH_PX, 3)


def test_high_dynamic_range_is_told(tmp_path: Path) -> None:
    path = write_video(tmp_path / "hdr.mp4", pixels="yuv420p10le", color_trc=18, color_primaries=9, colorspace=9)
    pictures, footage = read(path)
    assert len(pictures) == FRAMES
    assert footage.notes == ["hdr.mp4 has high dynamic range (HLG): its colours are not adapted to others"]


def test_of_a_large_video_the_latest_picture_is_kept_alone(tmp_path: Path) -> None:
    """Forty pictures would take 100 MB; in Python's memory there are never more than a few."""
    large = np.zeros((720, 1280, 3), np.uint8)
    path = write_video(tmp_path / "large.mp4", [large] * 40)
    footage = open_footage(str(path))
    tracemalloc.start()
    assert sum(1 for _ in footage.pictures()) == 40
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    footage.close()
    assert peak < 4 * large.nbytes


@pytest.mark.parametrize("name", ["cut.mkv", "cut.ts", "cut.mp4"])
def test_of_a_cut_off_file_the_beginning_is_used(tmp_path: Path, name: str) -> None:
    noise = np.random.default_rng(1)
    pictures = [noise.integers(0, 255, (HEIGHT_PX, WIDTH_PX, 3), np.uint8) for _ in range(40)]
    path = write_video(tmp_path / name, pictures, options={"movflags": "+faststart"} if name.endswith("mp4") else {})
    content = path.read_bytes()
    path.write_bytes(content[: len(content) // 2])
    found, footage = read(path)
    assert 5 < len(found) < 35
    told = " ".join(footage.notes)
    if not name.endswith("ts"):  # What tells its length lies at its end.
        assert re.search(rf"{name} ends after {len(found)} pictures of \d+", told), told


def test_a_damaged_part_is_told_and_passed_over(tmp_path: Path) -> None:
    path = write_video(tmp_path / "holes.mov", codec="mjpeg", pixels="yuvj420p")
    content = bytearray(path.read_bytes())
    middle = len(content) // 2
    content[middle : middle + 400] = bytes(400)
    path.write_bytes(content)
    pictures, footage = read(path)
    assert len(pictures) == FRAMES - 1
    assert footage.notes == ["holes.mov is damaged: 1 part of it cannot be decoded"]


def refused(source: Path | str) -> str:
    with pytest.raises(ValueError, match=r"^[a-z_]+: expected [^\n]*, got [^\n]*$") as error:
        read(source)
    return str(error.value)


def test_what_is_no_video_is_refused_in_one_line(tmp_path: Path) -> None:
    text = tmp_path / "text.mp4"
    text.write_text("this is no video\n" * 100)
    assert "text.mp4" in refused(text)
    (tmp_path / "notes.txt").write_text("hello\nworld\n" * 50)
    assert "notes.txt" in refused(tmp_path / "notes.txt")
    assert "an empty name" in refused("")
    (tmp_path / "empty.mp4").touch()
    assert "empty.mp4" in refused(tmp_path / "empty.mp4")
    assert "No such file" in refused(tmp_path / "none.mp4")
    assert "audio" in refused(write_sound(tmp_path / "sound.m4a"))
    (tmp_path / "folder").mkdir()
    assert "folder with pictures" in refused(tmp_path / "folder")


def test_a_file_without_its_index_is_refused(tmp_path: Path) -> None:
    path = write_video(tmp_path / "cut.mp4")
    content = path.read_bytes()
    path.write_bytes(content[: content.index(b"moov") - 4])
    assert "cut.mp4" in refused(path)


def test_a_file_that_may_not_be_read_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def denied(*_: object, **__: object) -> None:
        raise av.PermissionError(13, "Permission denied", "a.mp4")

    monkeypatch.setattr(av, "open", denied)
    assert "Permission denied" in refused(tmp_path / "a.mp4")


def test_a_folder_is_read_in_the_order_of_numbers(tmp_path: Path) -> None:
    for k in (0, 1, 2, 9, 10, 11):
        cv2.imwrite(str(tmp_path / f"shot{k}.png"), picture_of(k)[..., ::-1])
    (tmp_path / "notes.txt").write_text("not a picture")
    (tmp_path / "._shot1.png").write_bytes(b"macOS")
    footage = open_footage(str(tmp_path), 10.0)
    found = list(footage.pictures())
    assert [red_corner(each.image_rgb)[0] for each in found] == [corner_of(k)[0] for k in (0, 1, 2, 9, 10, 11)]
    np.testing.assert_allclose([each.time_s for each in found], np.arange(6) / 10)
    np.testing.assert_array_equal(found[1].image_rgb, picture_of(1))


def test_a_folder_ends_at_a_broken_picture(tmp_path: Path) -> None:
    for k in range(4):
        cv2.imwrite(str(tmp_path / f"{k}.png"), picture_of(k)[..., ::-1])
    (tmp_path / "2.png").write_bytes((tmp_path / "2.png").read_bytes()[:100])
    pictures, footage = read(tmp_path)
    assert len(pictures) == 2
    assert footage.notes == [f"{tmp_path.name} ends after 2 of 4 pictures: 2.png cannot be decoded"]
    cv2.imwrite(str(tmp_path / "2.png"), picture_of(2, size=(20, 30)))
    assert "2.png is not 160 x 120 pixels" in read(tmp_path)[1].notes[0]
    (tmp_path / "0.png").write_bytes(b"")
    assert "0.png" in refused(tmp_path)


def test_sixteen_bit_and_grey_pictures_are_reduced(tmp_path: Path) -> None:
    deep = cv2.cvtColor(picture_of(0), cv2.COLOR_RGB2GRAY).astype(np.uint16) * 257
    cv2.imwrite(str(tmp_path / "a.png"), deep)
    ((image, _), *_), _ = read(tmp_path)
    assert image.shape == (HEIGHT_PX, WIDTH_PX, 3)
    assert np.abs(image[..., 0].astype(int) - deep // 257).max() <= 1


def test_a_rate_is_for_folders_alone(tmp_path: Path) -> None:
    path = write_video(tmp_path / "a.mp4")
    with pytest.raises(ValueError, match="rate_hz: expected none but for a folder of pictures"):
        open_footage(str(path), 10.0)
    cv2.imwrite(str(tmp_path / "a.png"), picture_of(0))
    with pytest.raises(ValueError, match="rate_hz: expected a number of pictures a second > 0, got 0"):
        open_footage(str(tmp_path), 0.0)


def test_a_camera_that_is_not_there_is_refused(capfd: pytest.CaptureFixture[str]) -> None:
    assert all("number of a camera" in refused(number) for number in ("73", "9" * 11))
    assert capfd.readouterr().err == ""


def test_a_camera_gives_pictures_at_the_time_of_the_clock(monkeypatch: pytest.MonkeyPatch) -> None:
    class Device:
        def __init__(self, number: int) -> None:
            self.left = 3

        def isOpened(self) -> bool:
            return True

        def get(self, what: int) -> float:
            return 25.0

        def read(self) -> tuple[bool, NDArray[np.uint8] | None]:
            self.left -= 1
            return (True, picture_of(0)[..., ::-1]) if self.left >= 0 else (False, None)

        def release(self) -> None: ...

    monkeypatch.setattr(cv2, "VideoCapture", Device)
    camera = Camera(0)
    pictures = list(camera.pictures())
    assert len(pictures) == 3
    assert camera.rate_hz == 25.0
    np.testing.assert_array_equal(pictures[0].image_rgb, picture_of(0))
    assert all(b.time_s > a.time_s for a, b in itertools.pairwise(pictures))


class _Sudden(Footage):
    """Gives pictures faster than anyone reads them."""

    def pictures(self):  # type: ignore[no-untyped-def]
        for k in range(50):
            yield Picture(picture_of(0), k / 30)

    def close(self) -> None:
        self.closed = True


def test_of_live_footage_the_newest_picture_counts() -> None:
    live = Live(_Sudden("cam", 30.0))
    seen = []
    for picture in live.pictures():
        seen.append(picture.time_s)
        time.sleep(0.05)
    live.close()
    assert seen[-1] == 49 / 30
    assert len(seen) < 50
    (note,) = live.notes
    assert note.startswith(f"cam: {50 - len(seen)} pictures came while others were worked on")


def test_what_goes_wrong_in_a_reader_is_raised_where_it_is_read() -> None:
    class Broken(_Sudden):
        def pictures(self):  # type: ignore[no-untyped-def]
            yield from ()
            raise ValueError("video: expected one with pictures, got none")

    with pytest.raises(ValueError, match="expected one with pictures"):
        list(Live(Broken("cam", 30.0)).pictures())


def test_a_stream_of_a_network_is_read(tmp_path: Path) -> None:
    """A server on the loopback sends MPEG-TS at its own pace, as a camera does."""
    path = write_video(tmp_path / "a.ts", [picture_of(k) for k in range(30)])
    with socket.create_server(("127.0.0.1", 0)) as server:

        def serve() -> None:
            connection, _ = server.accept()
            with connection:
                connection.sendall(path.read_bytes())

        thread = threading.Thread(target=serve, daemon=True)
        thread.start()
        footage = open_footage(f"tcp://127.0.0.1:{server.getsockname()[1]}")
        assert footage.is_live
        pictures = list(footage.pictures())
        footage.close()
        thread.join(10)
    assert pictures
    assert pictures[0].image_rgb.shape == (HEIGHT_PX, WIDTH_PX, 3)


def test_an_address_that_nobody_answers_is_refused() -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        port = server.getsockname()[1]
    assert f"rtsp://127.0.0.1:{port}/live" in refused(f"rtsp://127.0.0.1:{port}/live")
