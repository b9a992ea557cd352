"""A tracker that is right until frame 20, and then does what its argument says; ``python faulty.py FAULT``."""

import os
import signal
import sys
import time

import numpy as np
from frameout_client import Estimate, serve

FAULT, FRAME = sys.argv[1], 20


def hang():
    """Sleep for ever."""
    while True:
        time.sleep(1.0)


def leave_a_daemon():
    """Start a process that leaves group and session, and whose parent is not this one any more."""
    if os.fork() == 0:
        os.setsid()
        if os.fork() == 0:
            hang()
        os._exit(0)
    os.wait()


def eat():
    """Take a gigabyte, slowly enough to be seen, and keep it."""
    eaten = []
    for _ in range(100):
        eaten.append(np.ones(10_000_000 // 8))
        time.sleep(0.01)
    hang()


def close_pipes():
    """Close all files but the standard ones."""
    os.closerange(3, 100)


FAULTS = {
    "hangs": hang,
    "crashes": lambda: os.kill(os.getpid(), signal.SIGSEGV),
    "raises": lambda: 1 / 0,
    "answers_half_nan": lambda: np.array([np.nan, 3.0]),
    "answers_three_numbers": lambda: np.zeros(3),
    "answers_text": lambda: "here",
    "prints": lambda: print("x" * 10_000_000),
    "closes_its_pipe": close_pipes,
    "forks": os.fork,
    "leaves_a_daemon": leave_a_daemon,
    "eats_memory": eat,
    "exits": lambda: os._exit(0),
    "exits_with_a_word": lambda: sys.exit("no weights for this"),
}


class Faulty:
    """Stays where the target was."""

    def __init__(self, parameters, rng):
        self._frame = 0

    def initialise(self, observation, box_xyxy):
        self._box_xyxy = box_xyxy

    def update(self, observation):
        self._frame += 1
        answer = FAULTS[FAULT]() if self._frame == FRAME and FAULT in FAULTS else None
        if not isinstance(answer, (np.ndarray, str)):
            answer = 0.5 * (self._box_xyxy[:2] + self._box_xyxy[2:])
        return answer if isinstance(answer, str) else Estimate(answer, self._box_xyxy)


if __name__ == "__main__":
    if FAULT == "hangs_at_start":
        hang()
    if FAULT == "says_nothing":
        sys.exit(0)
    if FAULT == "loads_long":
        time.sleep(2.0)
    if FAULT == "speaks_another_version":
        import frameout_client

        frameout_client.VERSION = 99
    serve(Faulty)
