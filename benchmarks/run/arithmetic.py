"""How libraries calculate under a command: with the same instructions on every x86-64 machine, and one thread.

NumPy, OpenBLAS, OpenCV and numba's compiler each choose instructions by the processor that they find. Sums are then in
another order, and ``exp`` and ``sin`` differ in the last digit, which is enough for a particle filter to decide
otherwise. All have forms for AVX2 with FMA, of 2013; commands use these and leave out AVX-512. On a processor with
AVX-512 the published rows of earlier machines, whose processors were not noted, come out so and not otherwise;
RESULTS.md names the known exception. PyTorch, of policies, is left as it is.

Matrices are small here, and threads wait for each other where cores are shared: on two cores, beside two busy
processes, a tracker with a low-rank background took 146 s with two threads, and 22 s with one.
"""

from __future__ import annotations

import platform
from collections.abc import Mapping

THREADS = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS")
"""OpenBLAS reads the first before the second."""
INSTRUCTIONS = {
    "NPY_DISABLE_CPU_FEATURES": "X86_V4 AVX512_ICL AVX512_SPR",
    "OPENBLAS_CORETYPE": "Haswell",
    "OPENCV_IPP": "avx2",
    "NUMBA_CPU_NAME": "haswell",
    "NUMBA_CPU_FEATURES": "",
}
"""Environment variable -> value, for x86-64 with AVX2. Each library reads its own when it is imported."""
INSTRUCTIONS_WITH_AVX_512 = {"OPENCV_CPU_DISABLE": "AVX512-SKX"}
"""Further ones for processors that have it; on others OpenCV would warn that there is nothing to disable."""
_NEEDED = ("avx2", "fma", "bmi", "bmi2", "f16c", "lzcnt", "movbe")
_EXCLUDED_BY = {"NPY_DISABLE_CPU_FEATURES": "NPY_ENABLE_CPU_FEATURES"}
"""NumPy refuses both."""


def missing_settings(environment: Mapping[str, str]) -> dict[str, str]:
    """Return the settings for this machine that an environment lacks; what a user has set in it stays."""
    threads = {THREADS[0]: "1"} if environment.keys().isdisjoint(THREADS) else {}
    instructions = {
        name: value
        for name, value in _instructions().items()
        if name not in environment and _EXCLUDED_BY.get(name, name) not in environment
    }
    return threads | instructions


def calculates_like_published(environment: Mapping[str, str]) -> bool:
    """Return whether libraries that were imported in this environment use the instructions of the published tables."""
    wanted = _instructions()
    return bool(wanted) and all(environment.get(name) == value for name, value in wanted.items())


def _instructions() -> dict[str, str]:
    """Return the settings that this machine can follow."""
    found = _features()
    if not all(found.get(name, False) for name in _NEEDED):
        return {}
    return INSTRUCTIONS | (INSTRUCTIONS_WITH_AVX_512 if found.get("avx512bw", False) else {})


def _features() -> Mapping[str, bool]:
    """Return the names that LLVM gives to the instructions of an x86-64 processor; none of another one."""
    if platform.machine().lower() not in ("x86_64", "amd64"):
        return {}
    # Imported here: of all modules that import this one, only a command line needs it.
    from llvmlite.binding import get_host_cpu_features

    found: Mapping[str, bool] = get_host_cpu_features()
    return found
