"""Commands compute with the same instructions on every x86-64 machine."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

from benchmarks.run import instruction_set
from benchmarks.run.instruction_set import (
    SETTINGS,
    SETTINGS_WITH_AVX_512,
    has_common_instructions,
    settings_missing_in,
)

_OF_2013 = dict.fromkeys(("avx2", "fma", "bmi", "bmi2", "f16c", "lzcnt", "movbe"), True)


@pytest.mark.parametrize(
    ("machine", "features", "expected"),
    [
        ("x86_64", _OF_2013 | {"avx512f": True}, SETTINGS | SETTINGS_WITH_AVX_512),
        ("x86_64", _OF_2013 | {"avx512f": False}, SETTINGS),
        ("AMD64", _OF_2013, SETTINGS),
        # It would die of an instruction that it does not have.
        ("x86_64", _OF_2013 | {"avx2": False}, {}),
        ("x86_64", {name: True for name in _OF_2013 if name != "fma"}, {}),
        ("arm64", _OF_2013, {}),
        ("aarch64", {"neon": True}, {}),
    ],
)
def test_only_a_machine_that_can_follow_them_gets_settings(
    machine: str, features: dict[str, bool], expected: dict[str, str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("platform.machine", lambda: machine)
    monkeypatch.setattr("llvmlite.binding.get_host_cpu_features", lambda: features)
    assert settings_missing_in({}) == expected
    assert has_common_instructions() == bool(expected)


def test_what_a_user_has_set_stays(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(instruction_set, "_features", lambda: _OF_2013)
    missing = settings_missing_in({"OPENBLAS_CORETYPE": "Zen", "NUMBA_CPU_NAME": "", "HOME": "/"})
    assert missing == {name: SETTINGS[name] for name in ("OPENCV_IPP", "NUMBA_CPU_FEATURES")}


@pytest.mark.skipif(not has_common_instructions(), reason="an x86-64 machine with AVX2 is needed")
def test_libraries_follow_the_settings_of_a_command() -> None:
    """As each library itself tells, so that a variable that it no longer reads is noticed."""
    script = """
import sys
from benchmarks.cli import main
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
    ours = {*SETTINGS, *SETTINGS_WITH_AVX_512}
    environment = {name: value for name, value in os.environ.items() if name not in ours}
    done = subprocess.run([sys.executable, "-c", script], env=environment, capture_output=True, text=True, check=True)
    assert done.stdout.splitlines()[1:] == ["True True False False", "True []", "('haswell', '')"]
    assert done.stderr == ""
