"""A process is ended with all that it has started. What a test starts here ends by itself after ``_LONGEST_S``."""

import os
import signal
import subprocess
import sys
import time
import uuid
from collections.abc import Callable
from pathlib import Path

import psutil
import pytest

from trackers.clients.child import Child, Limits, ProcessError

_LONGEST_S = 60.0

CHAIN = f"""
import os, sys, time
end = time.monotonic() + {_LONGEST_S}
sys.stdout.write("up\\n"); sys.stdout.flush()
while time.monotonic() < end:
    if os.fork():
        os._exit(0)
    os.setsid()
"""
"""A process that forks and exits, so does its child, and so on: each lives for less than a millisecond."""

DAEMON = f"""
import os, sys, time
if os.fork() == 0:
    os.setsid()
    if os.fork() == 0:
        os.execve(sys.executable, [sys.executable, "-c", "import time; time.sleep({_LONGEST_S})  # TOKEN"], {{}})
    os._exit(0)
os.wait()
sys.stdout.write("up\\n"); sys.stdout.flush()
time.sleep({_LONGEST_S})
"""
"""A process with a daemon that has neither its group, nor its session, nor its environment."""


def started(program: str) -> Child:
    """Return a process that has said a line."""
    child = Child([sys.executable, "-c", program], Limits(), {})
    child.exchange(b"", -1, lambda _, said: len(said) if b"\n" in said else None, 20.0, [child.stdout])
    return child


def programs_with(token: str) -> list[int]:
    """Return the processes whose command holds a word."""
    found = []
    for each in psutil.process_iter(["cmdline"]):
        if any(token in word for word in each.info["cmdline"] or ()):
            found.append(each.pid)
    return found


def within(seconds: float, true: Callable[[], bool]) -> bool:
    """Return whether something comes true in time."""
    end_s = time.monotonic() + seconds
    while not true() and time.monotonic() < end_s:
        time.sleep(0.02)
    return true()


@pytest.mark.skipif(sys.platform != "linux", reason="others have no subreaper")
class TestOnLinux:
    """What leaves the group and session of its program is ended too."""

    @pytest.fixture
    def token(self) -> str:
        return f"TOKEN-{uuid.uuid4()}"

    def test_a_chain_of_processes_that_start_each_other(self, token: str) -> None:
        child = started(f"{CHAIN}# {token}")
        assert within(5.0, lambda: bool(programs_with(token)))
        child.kill()
        for _ in range(20):
            assert programs_with(token) == []
            time.sleep(0.01)

    def test_a_daemon_without_its_environment(self, token: str) -> None:
        child = started(DAEMON.replace("TOKEN", token))
        [stray] = child.strays()
        assert stray in programs_with(token)
        child.kill()
        assert programs_with(token) == []
        assert child.strays() == set()

    @pytest.mark.parametrize("ended", ["runner", "keeper"])
    def test_the_program_of_a_runner_or_keeper_that_is_killed(self, ended: str, token: str, tmp_path: Path) -> None:
        (tmp_path / "program.py").write_text(DAEMON.replace("TOKEN", token))
        runner = f"""
import sys, time
from trackers.clients.child import Child, Limits
child = Child([sys.executable, {str(tmp_path / "program.py")!r}, {token!r}], Limits(), {{}})
child.exchange(b"", -1, lambda _, said: len(said) if b"\\n" in said else None, 20.0, [child.stdout])
print(child.keeper_pid, child.pid, flush=True)
time.sleep({_LONGEST_S})
"""
        with subprocess.Popen([sys.executable, "-c", runner], stdout=subprocess.PIPE, text=True) as process:
            assert process.stdout is not None
            keeper, program = map(int, process.stdout.readline().split())
            assert program in programs_with(token)
            os.kill(process.pid if ended == "runner" else keeper, signal.SIGKILL)
            assert within(5.0, lambda: not psutil.pid_exists(program))
            process.kill()
        if ended == "runner":
            assert within(5.0, lambda: programs_with(token) == [])
        for pid in programs_with(token):
            os.kill(pid, signal.SIGKILL)


def test_a_file_that_is_no_program_is_named(tmp_path: Path) -> None:
    (tmp_path / "data").write_bytes(b"no program")
    (tmp_path / "data").chmod(0o755)
    with pytest.raises(ProcessError, match=r"it cannot be started: .*Exec format error"):
        Child([str(tmp_path / "data")], Limits(), {})


def test_its_exit_status_and_cpu_time_are_known_after_its_end() -> None:
    burn = "import time\nwhile time.process_time() < 0.2: pass\nraise SystemExit({})"
    child = Child([sys.executable, "-c", burn.format(0)], Limits(), {})
    child.wait(20.0)
    assert 0.2 <= child.spent_cpu_s < 1.0
    child.kill()
    child = Child([sys.executable, "-c", burn.format(3)], Limits(), {})
    with pytest.raises(ProcessError, match="it ended with exit status 3, without a word"):
        child.wait(20.0)
    child.kill()
