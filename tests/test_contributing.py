"""CONTRIBUTING and the pages of results are followed word for word: files are written as shown, commands are run."""

from __future__ import annotations

import re
import shlex
import shutil
from pathlib import Path

import pytest

from benchmarks.cli.main import FRAMEOUT, main
from benchmarks.learning import playing
from tests.benchmarks.data.footage.written_footage import picture_of, write_video
from tests.documents import RESULTS, ROOT, blocks_of, commands, in_one_process, succeeds
from tools.__main__ import TOOLS


@pytest.mark.heavy
@pytest.mark.parametrize(
    "heading",
    [
        "Add a tracker",
        "Add a tracker of many targets",
        "Run a tracker in its own process",
        "Add a controller",
        "Add a metric",
        "Add a suite",
        "Add a street pattern",
        "Add a vehicle",
        "Your own meshes",
        "Add an export format",
    ],
)
def test_what_contributing_says_works(heading: str, tmp_path: Path) -> None:
    section = [block for block in blocks_of("CONTRIBUTING.md") if block.heading == heading]
    (file,) = [block.text for block in section if block.language == "python"]
    name = re.match(r"# (\w+\.py)\n", file)
    assert name, f"{heading}: expected the file's name on the first line"
    (tmp_path / name[1]).write_text(file)
    (shown,) = [block.text for block in section if block.language == "bash" and not block.mark]
    told = "".join(succeeds(in_one_process(command), tmp_path) for command in shown.splitlines())
    told += "".join(path.read_text() for path in tmp_path.rglob("summary.json"))
    expected = {
        "Add a tracker": '"tracker": "template_match"',
        "Add a tracker of many targets": '"tracker": "blobs"',
        "Run a tracker in its own process": '"tracker": "brightest"',
        "Add a controller": '"controller": "keep_above"',
        "Add a metric": '"metric": "jitter_px"',
        "Add a suite": '"suite": "while-seen"',
        "Add a street pattern": '"preset": "wheel"',
        "Add a vehicle": r"\[11\.",
        "Your own meshes": r"models/milk\.glb",
        "Add an export format": "results/centres",
    }
    assert re.search(expected[heading], told)


@pytest.mark.heavy
def test_the_file_of_processes_that_contributing_shows_runs(tmp_path: Path) -> None:
    section = [each for each in blocks_of("CONTRIBUTING.md") if each.heading == "Run a tracker in its own process"]
    texts = {each.language: each.text for each in section}
    (tmp_path / "brightest.py").write_text(texts["python"])
    (tmp_path / "trackers.toml").write_text(texts["toml"])
    bench = "frameout bench frame-out --process trackers.toml --trackers brightest_far --preset quick --seeds 0:1"
    succeeds(in_one_process(f"{bench} --out results"), tmp_path)
    assert '"tracker": "brightest_far"' in (tmp_path / "results" / "summary.json").read_text()


@pytest.mark.heavy
@pytest.mark.skipif(shutil.which("g++") is None, reason="no compiler of C++")
def test_the_tracker_in_cpp_that_contributing_shows_runs(tmp_path: Path) -> None:
    (tmp_path / "examples").symlink_to(ROOT / "examples")
    for command in commands("CONTRIBUTING.md", "cpp"):
        succeeds(in_one_process(command), tmp_path)
    assert '"tracker": "template"' in (tmp_path / "results" / "cpp" / "summary.json").read_text()


@pytest.mark.heavy
def test_the_scenes_that_contributing_shows_run_in_a_checkout(tmp_path: Path) -> None:
    for command in commands("CONTRIBUTING.md", "checkout"):
        succeeds(in_one_process(command).replace("results/", f"{tmp_path}/"), ROOT)
    assert '"metric": "found_rate"' in (tmp_path / "toy" / "summary.json").read_text()
    assert '"metric": "outside_error_px"' in (tmp_path / "belt" / "summary.json").read_text()
    assert (tmp_path / "belt.mp4").exists()


@pytest.mark.heavy
def test_answers_that_are_written_are_scored_as_contributing_says(tmp_path: Path) -> None:
    *_, compared = [succeeds(in_one_process(each), tmp_path) for each in commands("CONTRIBUTING.md", "elsewhere")]
    differences = re.findall(r"(\S+) +(\S+) … (\S+) +1\.0000 +2 *$", compared, re.M)
    assert differences
    assert {float(number) for each in differences for number in each} == {0.0}


@pytest.mark.heavy
def test_time_values_and_runs_are_compared_as_contributing_says(tmp_path: Path) -> None:
    fair, varied, compared, table = [
        succeeds(in_one_process(each), tmp_path) for each in commands("CONTRIBUTING.md", "fair")
    ]
    assert "in real time at 30 Hz" in fair
    assert "colour_pf[particles=200]" in varied
    assert "colour_pf[particles=50] minus colour_pf[particles=200]" in compared
    assert "| seed | colour_pf[particles=200] | colour_pf[particles=50] |" in table
    assert "What does a better score cost?" in (tmp_path / "results/compute/report.html").read_text()


@pytest.mark.heavy
def test_real_sequences_run_as_contributing_says(tmp_path: Path) -> None:
    *_, told = [succeeds(in_one_process(each), tmp_path) for each in commands("CONTRIBUTING.md", "real")]
    assert "vot: 1 sequence" in told or "road-town-v2-quick-000000: 1 sequence" in told


@pytest.mark.parametrize(
    "command", sorted({each for page in ("README.md", *RESULTS) for each in commands(page, "long")})
)
def test_long_commands_are_understood(
    command: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Everything in them is right but for the folder added here, which cannot be written."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(playing, "check_screen", lambda: None)
    (tmp_path / "file").touch()
    words = shlex.split(command.removeprefix("frameout ").removeprefix("python -m tools "))
    program = FRAMEOUT if command.startswith("frameout ") else TOOLS
    assert main([*words, "--out", "file/inside"], program) == 2
    assert "out: expected a folder that can be written" in capsys.readouterr().err


@pytest.mark.heavy
def test_a_video_of_ones_own_is_tracked_as_contributing_says(tmp_path: Path) -> None:
    write_video(tmp_path / "clip.mp4", [picture_of(k) for k in range(60)])
    section = [block for block in blocks_of("CONTRIBUTING.md") if block.heading == "Track your own video"]
    (shown,) = [block.text for block in section if block.language == "bash" and not block.mark]
    for command in (*shown.splitlines(), *commands("README.md", "video")):
        succeeds(in_one_process(command), tmp_path)
    made = {each.name for each in (tmp_path / "results").iterdir()}
    assert made == {"clip-correlation_filter.mp4", "clip-colour_pf.mp4", "clip-mosaic_graph_pf.mp4", "clip.csv"}


@pytest.mark.heavy
def test_python_about_envs_and_data_sets_in_contributing_runs(tmp_path: Path) -> None:
    texts = {block.heading: block.text for block in blocks_of("CONTRIBUTING.md") if block.language == "python"}
    succeeds("frameout generate road-town --preset quick --seeds 0:1 --workers 0 --out results/set", tmp_path)
    told = []
    for heading in ("Where the envs come from", "How a data set is stored"):
        (tmp_path / "look.py").write_text(texts[heading])
        told.append(succeeds("python look.py", tmp_path))
    assert 0.0 <= float(told[0]) <= 1.0
    assert told[1].startswith("(240, 320, 3) target in")


@pytest.mark.heavy
def test_the_data_sets_that_contributing_describes_are_made(tmp_path: Path) -> None:
    section = {
        each.language: each.text for each in blocks_of("CONTRIBUTING.md") if each.heading == "Describe a data set"
    }
    (tmp_path / "three.yaml").write_text(section["yaml"])
    succeeds("frameout generate --config three.yaml --out results/three --workers 0", tmp_path)
    assert succeeds("frameout verify results/three", tmp_path).count("all whole") == 2
    (tmp_path / "make_a_set.py").write_text(section["python"])
    told = succeeds("python make_a_set.py", tmp_path)
    assert re.fullmatch(r"\[\] \{'train': \(0, 2\), 'val': \(1, 3\)\} 16\n", told), told
    assert (tmp_path / "results/made-yolo/data.yaml").is_file()


@pytest.mark.heavy
def test_rollouts_are_played_again_as_contributing_says(tmp_path: Path) -> None:
    section = {each.language: each.text for each in blocks_of("CONTRIBUTING.md") if each.heading == "Rollouts as data"}
    succeeds(in_one_process(section["bash"].strip()), tmp_path)
    (tmp_path / "play_again.py").write_text(section["python"])
    assert succeeds("python play_again.py", tmp_path) == "True\n"


@pytest.mark.heavy
def test_python_about_results_in_contributing_runs(tmp_path: Path) -> None:
    (text,) = [each.text for each in blocks_of("CONTRIBUTING.md") if each.heading == "From Python"]
    (tmp_path / "look.py").write_text(text)
    told = succeeds("python look.py", tmp_path)
    assert re.search(r"^colour_pf( +\d+\.\d+){2}$", told, re.M)
    assert (tmp_path / "results" / "python" / "error.png").read_bytes().startswith(b"\x89PNG")


def test_files_that_the_documents_point_to_exist() -> None:
    for name in ("README.md", "CONTRIBUTING.md", *RESULTS):
        text = (ROOT / name).read_text()
        for target in re.findall(r"\]\(([^)#:]+)", text):
            assert (ROOT / name).parent.joinpath(target).is_file(), target
        for path in re.findall(r"`((?:sim|trackers|scenarios|benchmarks|tools|tests)/[\w/.]+)`", text):
            assert "NAME" in path or (ROOT / path).exists(), path


def test_the_documents_have_the_blocks_that_are_followed() -> None:
    assert len(commands("README.md", "")) >= 5
    assert "frameout train frameout/RoadTownFollow-v3" in commands("README.md", "long")
    long = {each for page in RESULTS for each in commands(page, "long")}
    assert {"frameout paper A2 --renderer pybullet", "python -m tools speed"} <= long
    assert len((ROOT / "README.md").read_text().splitlines()) <= 150
