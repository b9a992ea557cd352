"""Where nothing can be written, kernels have a temporary folder, which is told once and given to other processes."""

from __future__ import annotations

import os
from pathlib import Path

import numba
import pytest
from numba import njit

from sim import kernel_cache
from sim.kernel_cache import ensure_kernel_cache


@pytest.fixture(autouse=True)
def restored(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(numba.config, "CACHE_DIR", numba.config.CACHE_DIR)
    monkeypatch.setattr(kernel_cache, "_folder", None)


def test_a_folder_that_can_be_written_is_taken_in_silence(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    ensure_kernel_cache()
    assert os.environ["NUMBA_CACHE_DIR"] == str(tmp_path)
    assert capsys.readouterr().err == ""


def test_without_any_kernels_have_a_private_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    unwritable = tmp_path / "file"
    unwritable.touch(0o400)
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(unwritable))
    # Root may write everywhere: numba refuses as it does for others.
    monkeypatch.setattr(os, "access", lambda place, mode: place != str(unwritable))
    monkeypatch.setattr(numba, "njit", _refusing)
    ensure_kernel_cache()
    folder = Path(os.environ["NUMBA_CACHE_DIR"])
    assert str(folder) == numba.config.CACHE_DIR
    assert folder.stat().st_mode & 0o077 == 0
    told = capsys.readouterr().err
    assert len(told.splitlines()) == 1
    assert f"{folder} until this process ends" in told
    monkeypatch.setattr(numba, "njit", njit)
    ensure_kernel_cache()
    assert os.environ["NUMBA_CACHE_DIR"] == str(folder)
    assert capsys.readouterr().err == ""
    kernel_cache._folder.cleanup()


def _refusing(**options: object) -> object:
    def decorate(kernel: object) -> object:
        raise RuntimeError("cannot cache function: no locator available")

    return decorate
