"""Kernels that are compiled, stale or not there yet."""

from __future__ import annotations

import os
import subprocess
import sys
from types import SimpleNamespace

import pytest

from sim.render.compilation import forget_stale_kernels
from sim.render.rows import mip_level

DRAW = """
from sim.render.compilation import announce_compilation
from sim.render.rows import mip_level
announce_compilation(mip_level)
mip_level(9.0, 4)
"""


def test_compiled_forms_older_than_any_source_are_removed(tmp_path):
    cache = tmp_path / "__pycache__"
    cache.mkdir()
    source, old, new = tmp_path / "kernel.py", cache / "kernel.old.nbi", cache / "kernel.new.nbi"
    for path, age_s in ((old, 100), (source, 50), (new, 10)):
        path.touch()
        os.utime(path, (1e9 - age_s, 1e9 - age_s))
    forget_stale_kernels(tmp_path)
    assert sorted(cache.iterdir()) == [new]


class _Caller:
    """What is asked of a compiled function: where its forms are kept."""

    def __init__(self, folder):
        self.py_func = mip_level.py_func
        self.stats = SimpleNamespace(cache_path=str(folder))


def test_compiled_forms_of_a_caller_older_than_what_it_calls_are_removed(tmp_path):
    cache, package = tmp_path / "cache", tmp_path / "package"
    cache.mkdir()
    package.mkdir()
    stale, other, source = cache / "rows.mip_level-1.nbi", cache / "rows.other-1.nbi", package / "kernel.py"
    for path, age_s in ((stale, 100), (other, 100), (source, 50)):
        path.touch()
        os.utime(path, (1e9 - age_s, 1e9 - age_s))
    forget_stale_kernels(package, _Caller(cache))
    assert sorted(cache.iterdir()) == [other]


@pytest.mark.heavy
def test_the_first_run_says_that_it_compiles_and_the_second_does_not(tmp_path):
    environment = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path)}
    said = [
        subprocess.run([sys.executable, "-c", DRAW], env=environment, capture_output=True, text=True, check=True).stderr
        for _ in range(2)
    ]
    assert "compiling kernels (first run only)" in said[0]
    assert said[1] == ""
