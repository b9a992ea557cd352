from __future__ import annotations

import errno
import json
import os
import re
import subprocess
import sys
import textwrap
from pathlib import Path

import pytest

from benchmarks.cli.main import main
from benchmarks.contract.rows import read, read_blocks
from benchmarks.run.arithmetic import INSTRUCTIONS, INSTRUCTIONS_WITH_AVX_512, THREADS

FAKES = "fake_knowing,fake_still"


pytestmark = pytest.mark.usefixtures("fake_suite")


def bench(out: Path, *more: str) -> int:
    """Run a small bench in this process."""
    return main(["bench", "--workers", "0", "--seeds", "0:2", "--trackers", FAKES, "--out", str(out), *more])


def test_bench_prints_the_leaderboard_and_names_its_report(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert bench(tmp_path) == 0
    out, _ = capsys.readouterr()
    lines = [line for line in out.splitlines() if "fake_" in line]
    assert [line.split()[0] for line in lines] == ["fake_knowing", "fake_still"]
    assert str(tmp_path / "report.html") in out
    assert (tmp_path / "report.html").is_file()


def test_json_is_all_that_stdout_holds(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    assert bench(tmp_path, "--json") == 0
    out, _ = capfd.readouterr()
    document = json.loads(out)
    assert document["summary"] == json.loads((tmp_path / "summary.json").read_text())
    assert document["failures"] == []


def test_a_tracker_that_fails_is_told_in_one_line_and_in_the_status(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert bench(tmp_path, "--trackers", "fake_raises", "fake_still", "fake_silent") == 1
    out, err = capsys.readouterr()
    told = [line for line in err.splitlines() if "fake_" in line]
    failed = "error: fake_raises failed in fake-town-v1 tiny, seed 0, frame 20"
    assert told[0].startswith(f"{failed}: RuntimeError: a bug (fakes_trackers.py, line ")
    assert told[0].endswith("(and 1 more failure)")
    assert "note: fake_silent gave no answer (NaN) on 440 frames" in told[1]
    assert "Traceback" not in out + err


@pytest.mark.heavy
def test_report_is_made_again_from_rows_alone(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    bench(tmp_path)
    made = {name: (tmp_path / name).read_bytes() for name in ("summary.json", "comparisons.json", "report.html")}
    for name in made:
        (tmp_path / name).unlink()
    assert main(["report", str(tmp_path)]) == 0
    assert {name: (tmp_path / name).read_bytes() for name in made} == made
    assert capsys.readouterr().out.endswith(f"{tmp_path / 'report.html'}\n")


def test_a_report_stays_until_rows_metrics_or_code_are_new(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    bench(tmp_path)
    page = tmp_path / "report.html"
    first, made = page.read_bytes(), page.stat().st_mtime_ns
    capsys.readouterr()
    assert bench(tmp_path) == 0
    assert "nothing new: the report stays as it is" in capsys.readouterr().err
    assert page.stat().st_mtime_ns == made
    page.unlink()
    assert bench(tmp_path) == 0
    assert page.read_bytes() == first
    bench(tmp_path, "--metric", "kept_rate")
    assert page.read_bytes() != first
    monkeypatch.setattr("benchmarks.show.page._digest_of_code", lambda: "another")
    capsys.readouterr()
    bench(tmp_path, "--metric", "kept_rate")
    assert "making the report" in capsys.readouterr().err


def test_compare_and_report_name_modules_that_they_were_not_given(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    bench(tmp_path, "--modules", "tests.fakes_scenario")
    told = f"note: the rows of {tmp_path} were made with tests.fakes_scenario; metrics, suites and scenes"
    for words in (["report", str(tmp_path)], ["compare", *FAKES.split(","), "--directory", str(tmp_path)]):
        capsys.readouterr()
        assert main(words) == 0
        assert told in capsys.readouterr().err
        assert main([*words, "--modules", "tests.fakes_scenario"]) == 0
        assert told not in capsys.readouterr().err


@pytest.mark.heavy
def test_report_and_compare_say_which_lines_they_ignore(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    bench(tmp_path)
    rows = tmp_path / "records.jsonl"
    with rows.open("ab") as file:
        file.write(b'\xff\xfe\n{"suite": "frame-out", "scen')
    capsys.readouterr()
    told = f"note: ignored 2 lines of {rows}: 2 that are no rows, 0 of episodes that were cut off or made again later\n"
    assert main(["report", str(tmp_path)]) == 0
    assert capsys.readouterr().err == told
    assert main(["compare", *FAKES.split(","), "--directory", str(tmp_path)]) == 0
    assert capsys.readouterr().err == told
    assert rows.read_bytes().count(b"\xff") == 1


@pytest.mark.heavy
def test_rows_of_other_editions_are_set_aside_and_said(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    bench(tmp_path)
    rows = tmp_path / "records.jsonl"
    made = re.sub(r'"judge": "[^"]+"', '"judge": "another"', rows.read_text())
    rows.write_text(made)
    capsys.readouterr()
    assert bench(tmp_path) == 0
    aside = tmp_path / "records.outdated-1.jsonl"
    count = len(made.splitlines())
    told = f"note: {count} rows that are outdated, cut off or broken were moved to {aside} (rows of other editions or "
    assert told in capsys.readouterr().err
    assert aside.read_text() == made


@pytest.mark.heavy
def test_a_full_disk_is_reported_in_one_line_and_the_same_command_continues(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    room = [True]

    def fsync(descriptor: int) -> None:
        if not room:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        room.pop()

    with monkeypatch.context() as full:
        full.setattr(os, "fsync", fsync)
        assert bench(tmp_path) == 1
    errors = capsys.readouterr().err.splitlines()
    rows = tmp_path / "records.jsonl"
    assert [line for line in errors if "error" in line] == [
        f"error: {rows}: No space left on device; what was written before is kept"
    ]
    assert "Traceback" not in "".join(errors)
    assert len(read_blocks(tmp_path)) == 1
    assert read(tmp_path).broken == read(tmp_path).replaced == []
    assert bench(tmp_path) == 0
    assert len(read_blocks(tmp_path)) == 4


_MISTAKES = {
    "role": (
        """
        from tests.fakes_trackers import Still
        from trackers.registry import register
        register("mine", role="our", summary="")(Still)
        """,
        4,
        "role: expected one of ours, .*; got 'our'",
    ),
    "parameters": (
        """
        from trackers.registry import register
        @register("mine", role="external", summary="")
        class Mine: pass
        """,
        3,
        "Parameters: expected a dataclass of this name in class Mine, got none",
    ),
    "syntax": ("\n\ndef half(:\n", 3, "SyntaxError: invalid syntax"),
    "ends": ("import sys\nsys.exit('no arguments')\n", 2, "SystemExit: no arguments"),
}


@pytest.mark.parametrize("mistake", _MISTAKES)
def test_a_mistake_in_a_users_module_is_said_with_its_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, mistake: str
) -> None:
    """Before anything is run, and not when the whole run is over."""
    source, line, reason = _MISTAKES[mistake]
    file = tmp_path / f"with_a_mistake_{mistake}.py"
    file.write_text(textwrap.dedent(source))
    monkeypatch.syspath_prepend(str(tmp_path))
    assert bench(tmp_path / "out", "--modules", file.stem) == 2
    (error,) = capsys.readouterr().err.splitlines()
    assert error.startswith("error: modules: expected one that can be imported, got ")
    assert f", {file}, line {line}: " in error
    assert re.search(reason, error)
    assert not (tmp_path / "out").exists()


@pytest.mark.heavy
def test_report_prints_the_leaderboard_in_markdown(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    bench(tmp_path)
    capsys.readouterr()
    assert main(["report", str(tmp_path), "--markdown"]) == 0
    lines = [line.strip() for line in capsys.readouterr().out.splitlines() if line.startswith("|")]
    head, rule, *rows = ([cell.strip() for cell in line.strip("|").split("|")] for line in lines)
    assert head[:3] == ["tracker", "role", "recovery rate (%) ↑"]
    assert all(set(cell) <= {"-", ":"} for cell in rule)
    assert [row[0] for row in rows] == ["`fake_knowing`", "`fake_still`"]
    summary = json.loads((tmp_path / "summary.json").read_text())
    for row in rows:
        entry = next(e for e in summary if e["metric"] == "recovery_rate" and e["tracker"] == row[0].strip("`"))
        percents = [100 * entry[key] for key in ("mean", "ci_low", "ci_high")]
        assert [float(number) for number in re.findall(r"[\d.]+", row[2])] == pytest.approx(percents, abs=0.05)


def test_compare_shows_differences_by_attribute(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    bench(tmp_path)
    capsys.readouterr()
    assert main(["compare", "fake_knowing", "fake_still", "--directory", str(tmp_path), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    by_name = {(entry["frame_outs"], entry["metric"]): entry for entry in found}
    assert by_name["all", "recovered"]["difference"] == 1.0
    assert by_name["left by the left", "recovered"]["difference"] == 1.0
    assert ("off the road", "recovered") not in by_name
    assert all(entry["p_holm"] >= entry["p"] for entry in found)
    there = f"{tmp_path}:fake_knowing"
    assert main(["compare", there, there, "--json"]) == 0
    assert all(entry["difference"] == 0.0 for entry in json.loads(capsys.readouterr().out))
    words = ["compare", "fake_knowing", "fake_still", "--directory", str(tmp_path)]
    assert main(words) == 0
    assert "fake_knowing minus fake_still" in capsys.readouterr().out
    assert main([*words, "--metric", "recovered", "--json"]) == 0
    # Chosen ones keep their p-values, which are corrected for all.
    assert json.loads(capsys.readouterr().out) == [entry for entry in found if entry["metric"] == "recovered"]
    assert main([*words, "--metric", "recoverd"]) == 2
    assert "got 'recoverd' (did you mean recovered?)" in capsys.readouterr().err


@pytest.mark.heavy
def test_a_reader_who_leaves_early_sees_no_traceback() -> None:
    listing = f"{sys.executable} -m benchmarks.cli.main list --metrics | head -1; echo ${{PIPESTATUS[0]}}"
    done = subprocess.run(["bash", "-c", listing], capture_output=True, text=True, check=True)
    assert (done.stdout.splitlines()[-1], done.stderr) == ("141", "")


@pytest.mark.heavy
def test_commands_and_workers_start_without_packages_that_only_some_need() -> None:
    """They take longer to import than all the rest, in every process."""
    script = """
import sys
import benchmarks.cli.bench, benchmarks.cli.render
from benchmarks.contract.suite import suites
from scenarios import catalog
from trackers.registry import entries
suites(), entries(), [catalog.scenario(name) for name in catalog.names()]
print(sorted({"matplotlib", "pandas", "scipy.signal", "scipy.stats", "statsmodels", "torch"} & sys.modules.keys()))
"""
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert done.stdout == "[]\n"


@pytest.mark.heavy
@pytest.mark.skipif(os.cpu_count() == 1, reason="OpenBLAS has no more threads than cores")
@pytest.mark.parametrize(
    ("asked", "used"), [({}, 1), ({"OPENBLAS_NUM_THREADS": "2"}, 2), ({"OMP_NUM_THREADS": "2"}, 2)]
)
def test_commands_use_one_thread_for_matrices_unless_told_otherwise(asked: dict[str, str], used: int) -> None:
    script = """
import sys
from benchmarks.cli.main import main
sys.argv = ["frameout", "--version"]
main()
import numpy, threadpoolctl
print({pool["num_threads"] for pool in threadpoolctl.threadpool_info() if pool["internal_api"] == "openblas"})
"""
    names = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS")
    environment = {name: value for name, value in os.environ.items() if name not in names} | asked
    done = subprocess.run([sys.executable, "-c", script], env=environment, capture_output=True, text=True, check=True)
    if (told := done.stdout.splitlines()[-1]) == "set()":
        pytest.skip("this NumPy has no OpenBLAS")
    assert told == str({used})


def test_a_call_from_python_leaves_the_environment_as_it_is(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in (*THREADS, *INSTRUCTIONS, *INSTRUCTIONS_WITH_AVX_512):
        monkeypatch.delenv(name, raising=False)
    before = dict(os.environ)
    assert main(["--version"]) == 0
    assert dict(os.environ) == before
