"""Commands calculate with the same instructions on every x86-64 machine."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

from benchmarks.run.arithmetic import (
    INSTRUCTIONS,
    INSTRUCTIONS_WITH_AVX_512,
    THREADS,
    calculates_like_published,
    missing_settings,
)

_OF_2013 = dict.fromkeys(("avx2", "fma", "bmi", "bmi2", "f16c", "lzcnt", "movbe"), True)
_ONE_THREAD = {"OPENBLAS_NUM_THREADS": "1"}


def _machine(monkeypatch: pytest.MonkeyPatch, name: str, features: dict[str, bool]) -> None:
    monkeypatch.setattr("platform.machine", lambda: name)
    monkeypatch.setattr("llvmlite.binding.get_host_cpu_features", lambda: features)


@pytest.mark.parametrize(
    ("machine", "features", "expected"),
    [
        ("x86_64", _OF_2013 | {"avx512bw": True}, INSTRUCTIONS | INSTRUCTIONS_WITH_AVX_512),
        ("x86_64", _OF_2013 | {"avx512bw": False}, INSTRUCTIONS),
        ("AMD64", _OF_2013, INSTRUCTIONS),
        # It would die of an instruction that it does not have.
        ("x86_64", _OF_2013 | {"avx2": False}, {}),
        ("x86_64", {name: True for name in _OF_2013 if name != "fma"}, {}),
        ("arm64", _OF_2013, {}),
        ("aarch64", {"neon": True}, {}),
    ],
)
def test_only_a_machine_that_can_follow_them_gets_instructions(
    machine: str, features: dict[str, bool], expected: dict[str, str], monkeypatch: pytest.MonkeyPatch
) -> None:
    _machine(monkeypatch, machine, features)
    assert missing_settings({}) == _ONE_THREAD | expected
    assert calculates_like_published(expected) == bool(expected)


def test_what_a_user_has_set_stays(monkeypatch: pytest.MonkeyPatch) -> None:
    _machine(monkeypatch, "x86_64", _OF_2013)
    missing = missing_settings({"OPENBLAS_CORETYPE": "Zen", "NUMBA_CPU_NAME": "", "OMP_NUM_THREADS": "2", "HOME": "/"})
    left = ("NPY_DISABLE_CPU_FEATURES", "OPENCV_IPP", "NUMBA_CPU_FEATURES")
    assert missing == {name: INSTRUCTIONS[name] for name in left}
    # NumPy refuses to be imported with both.
    assert "NPY_DISABLE_CPU_FEATURES" not in missing_settings({"NPY_ENABLE_CPU_FEATURES": "X86_V3"})


@pytest.mark.parametrize(("name", "value"), [("OPENBLAS_CORETYPE", "Zen"), ("NUMBA_CPU_NAME", None)])
def test_other_settings_than_those_of_the_published_tables_are_noticed(
    name: str, value: str | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    _machine(monkeypatch, "x86_64", _OF_2013)
    assert calculates_like_published(INSTRUCTIONS | {"HOME": "/"})
    other = {key: each for key, each in (INSTRUCTIONS | {name: value}).items() if each is not None}
    assert not calculates_like_published(other)


@pytest.mark.skipif(len(missing_settings({})) == len(_ONE_THREAD), reason="an x86-64 machine with AVX2 is needed")
def test_libraries_follow_the_settings_of_a_command() -> None:
    """As each library itself tells, so that a variable that it no longer reads is noticed."""
    script = """
import sys
from benchmarks.cli.main import main
sys.argv = ["frameout", "--version"]
main()
import cv2, numba, threadpoolctl
from numpy._core._multiarray_umath import __cpu_features__ as found
from numba.core.registry import cpu_target
blas = [pool["architecture"] for pool in threadpoolctl.threadpool_info() if pool["internal_api"] == "openblas"]
print(set(blas) <= {"Haswell"}, found["X86_V3"], found["X86_V4"], found["AVX512_ICL"])
enabled = [name for name in cv2.getCPUFeaturesLine().split() if "AVX512" in name and not name.endswith("?")]
print("AVX2" in cv2.ipp.getIppVersion() or not cv2.ipp.useIPP(), enabled)
print(cpu_target.target_context.codegen().magic_tuple()[1:])
"""
    ours = {*INSTRUCTIONS, *INSTRUCTIONS_WITH_AVX_512, *THREADS}
    environment = {name: value for name, value in os.environ.items() if name not in ours}
    done = subprocess.run([sys.executable, "-c", script], env=environment, capture_output=True, text=True, check=True)
    assert done.stdout.splitlines()[1:] == ["True True False False", "True []", "('haswell', '')"]
    assert done.stderr == ""
