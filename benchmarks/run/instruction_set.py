"""The processor instructions that commands compute with: the same on every x86-64 machine, so that figures are.

NumPy, OpenBLAS, OpenCV and numba's compiler each choose instructions by the processor that they find. Sums are then in
another order, and ``exp`` and ``sin`` differ in the last digit, which is enough for a particle filter to decide
otherwise. All have forms for AVX2 with FMA, of 2013; commands use these and leave out AVX-512. Two generations of
processors, one with and one without AVX-512, gave the same rows so, and other rows without it.
"""

from __future__ import annotations

import platform
from collections.abc import Mapping

SETTINGS = {
    "OPENBLAS_CORETYPE": "Haswell",
    "OPENCV_IPP": "avx2",
    "NUMBA_CPU_NAME": "haswell",
    "NUMBA_CPU_FEATURES": "",
}
"""Environment variable -> value. Each library reads its own when it is imported."""
SETTINGS_WITH_AVX_512 = {
    "NPY_DISABLE_CPU_FEATURES": "X86_V4 AVX512_ICL AVX512_SPR",
    "OPENCV_CPU_DISABLE": "AVX512-SKX",
}
"""Further ones for processors that have it; on others these libraries warn that there is nothing to disable."""
_NEEDED = ("avx2", "fma", "bmi", "bmi2", "f16c", "lzcnt", "movbe")


def settings_missing_in(environment: Mapping[str, str]) -> dict[str, str]:
    """Return the settings for this machine that an environment lacks; none for one that cannot follow them."""
    if not has_common_instructions():
        return {}
    settings = SETTINGS | (SETTINGS_WITH_AVX_512 if _features().get("avx512f", False) else {})
    return {name: value for name, value in settings.items() if name not in environment}


def has_common_instructions() -> bool:
    """Return whether this is an x86-64 machine with AVX2 and what came with it."""
    found = _features()
    return all(found.get(name, False) for name in _NEEDED)


def _features() -> Mapping[str, bool]:
    """Return the names that LLVM gives to the instructions of an x86-64 processor; none of another one."""
    if platform.machine().lower() not in ("x86_64", "amd64"):
        return {}
    # Imported here: of all modules that import this one, only a command line asks.
    from llvmlite.binding import get_host_cpu_features

    found: Mapping[str, bool] = get_host_cpu_features()
    return found
