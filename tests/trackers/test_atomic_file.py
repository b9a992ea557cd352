from __future__ import annotations

import errno
import os
import stat
from pathlib import Path

import pytest

from trackers.atomic_file import atomic_file, write_atomic


def test_a_file_is_replaced_as_a_whole_or_not_at_all(tmp_path: Path) -> None:
    path = tmp_path / "rows"
    write_atomic(path, "ä\n")
    assert path.read_bytes() == "ä\n".encode()

    def half() -> None:
        with atomic_file(path) as file:
            file.write(b"half")
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        half()
    assert [each.name for each in tmp_path.iterdir()] == ["rows"]
    assert path.read_bytes() == "ä\n".encode()


def test_a_link_at_the_temporary_name_is_not_followed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Even if the random name is predicted, a link there is not written through."""
    monkeypatch.setattr("secrets.token_hex", lambda count: "drawn")
    (tmp_path / "precious").write_text("whole")
    (tmp_path / ".rows.drawn").symlink_to(tmp_path / "precious")
    with pytest.raises(FileExistsError):
        write_atomic(tmp_path / "rows", "mine")
    assert (tmp_path / ".rows.drawn").read_text() == "whole"


def test_two_machines_with_one_process_id_do_not_write_into_each_other(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(os, "getpid", lambda: 7)
    path = tmp_path / "rows"
    with atomic_file(path) as first:
        first.write(b"first")
        with atomic_file(path) as second:
            second.write(b"second")
        assert path.read_bytes() == b"second"
    assert path.read_bytes() == b"first"


def test_others_may_read_it_as_any_new_file(tmp_path: Path) -> None:
    write_atomic(tmp_path / "rows", "")
    (tmp_path / "touched").touch()
    modes = {stat.S_IMODE((tmp_path / name).stat().st_mode) for name in ("rows", "touched")}
    assert len(modes) == 1


def test_a_full_disk_is_reported_for_the_files_own_name(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(descriptor: int) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(OSError, match="No space left") as caught:
        write_atomic(tmp_path / "rows", "mine")
    assert caught.value.filename == str(tmp_path / "rows")
    assert list(tmp_path.iterdir()) == []
