"""README is followed word for word: its commands and its Python run, one after the other."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import pytest

from benchmarks.cli.main import main
from tests.documents import ROOT, blocks_of, commands, in_one_process, succeeds


@pytest.mark.heavy
def test_commands_of_the_readme_run_one_after_the_other(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """In this process, which has loaded what they need; those of CONTRIBUTING register things and get their own."""
    monkeypatch.chdir(tmp_path)
    for command in commands("README.md", ""):
        program, *words = shlex.split(in_one_process(command))
        assert program == "frameout"
        assert main(words) == 0, command
        out = re.search(r"--out (\S+)", command)
        assert out is None or (tmp_path / out[1]).exists()


@pytest.mark.heavy
def test_python_in_the_readme_runs(tmp_path: Path) -> None:
    blocks = [block.text for block in blocks_of("README.md") if block.language == "python"]
    told = []
    for text in blocks:
        if "stable_baselines3" in text:
            pytest.importorskip("stable_baselines3")
        (tmp_path / "look.py").write_text(text)
        told.append(succeeds("python look.py", tmp_path))
    with_sb3, loop = told
    shares = re.fullmatch(
        r"PPO: the car is in view (\d+)% of the time\nhovering: the car is in view (\d+)% .*\n", with_sb3
    )
    assert shares is not None
    assert int(shares[1]) > int(shares[2])
    assert loop.startswith("(240, 320, 3) in")


@pytest.mark.heavy
def test_envs_side_by_side_are_made_as_the_readme_says(tmp_path: Path) -> None:
    (call,) = re.findall(r"`(gym\.make_vec\(ID, .*?\))`", (ROOT / "README.md").read_text())
    named = call.replace("ID, 8", "'scenarios:frameout/StereoFollow-v3', 2, preset='quick', tracker='stereo_wb'")
    script = f"import gymnasium as gym\nenvs = {named}\nprint(envs.reset(seed=0)[0].shape[0])\nenvs.close()\n"
    (tmp_path / "side_by_side.py").write_text(script)
    assert succeeds("python side_by_side.py", tmp_path) == "2\n"
