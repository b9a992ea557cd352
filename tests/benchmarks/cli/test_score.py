"""Predictions made elsewhere: their rows are those of the tracker that made them."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trackeval
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st

from benchmarks import TrackerWarning, bench, score
from benchmarks.cli.main import main
from benchmarks.contract.rows import read_rows
from benchmarks.contract.suite import Scene
from benchmarks.contract.tracker_spec import EpisodeName, TrackerSpec
from benchmarks.data.estimates.block_file import facts_in, read_block
from benchmarks.data.estimates.keeping import Estimates
from benchmarks.data.exports.exporter import export
from benchmarks.data.mot_text import read_mot
from benchmarks.data.predictions.writing import write_predictions
from benchmarks.data.sets.data_set import DataSet
from benchmarks.judges.frame_out.suite import FRAME_OUT
from benchmarks.judges.identities import Pairing, clear_counts, hota, identity_counts, numbered
from benchmarks.judges.tracker_speed import TIMES
from benchmarks.run.experiment import Experiment, run
from benchmarks.run.selection import experiment_on
from scenarios.fish_tank.scenario import FISH_TANK
from scenarios.loop import FromPictures, LoopTracker, ManyFromPictures
from scenarios.scenario import Episode
from tests import fakes_scenario
from tests.benchmarks.data.layouts.written_layouts import write_coco, write_tao, write_tao_amodal
from tests.benchmarks.data.written_sequences import lines_of, true_boxes, write_lines, write_otb
from trackers.kernels.boxes import intersections_over_union
from trackers.regions import Mask, Rectangle, estimate_of
from trackers.registry import NoParameters
from trackers.types import CameraModel, Estimate, Observation, Track

SUITE = replace(
    FRAME_OUT, scenes=(Scene(fakes_scenario.FAKE_TOWN.id, "frame-out"),), preset="brief", quick_preset="brief"
)
FRAMES = 70
POSTERIOR = ("coverage_", "nees", "credible_level_histogram")


@pytest.fixture(autouse=True)
def _presets(monkeypatch: pytest.MonkeyPatch) -> None:
    town, few = fakes_scenario.FAKE_TOWN.presets["tiny"], FISH_TANK.presets["paper-c"]
    monkeypatch.setitem(fakes_scenario.FAKE_TOWN.presets, "brief", replace(town, frame_count=FRAMES))
    monkeypatch.setitem(FISH_TANK.presets, "few", replace(few, fish=3, glare=0.0, frame_count=40))


@dataclass(frozen=True, kw_only=True)
class Drawn(TrackerSpec):
    """Answers at random, silence, no box and no probability among them; the position is the middle of the box."""

    role: str = "external"
    summary: str = "by lot"
    suites: tuple[str, ...] = ()
    parameters: Any = field(default_factory=NoParameters)
    module: str = __name__
    draw: int

    def create(
        self, named: EpisodeName, episode: Episode, rng: np.random.Generator, *, many: bool = False
    ) -> LoopTracker:
        """See ``TrackerSpec``."""
        camera = episode.start.camera
        lot = Lot(np.random.default_rng(self.draw + named.seed), camera.width_px, camera.height_px)
        return ManyFromPictures(lot) if many else FromPictures(One(lot))


class Lot:
    """See ``MultiTracker``."""

    def __init__(self, rng: np.random.Generator, width_px: int, height_px: int) -> None:
        self._rng, self._size_px, self._far = rng, np.array([width_px, height_px]), rng.uniform(1.0, 1.5)
        self._places = rng.uniform(0, self._size_px, (3, 2))

    def start(self, background: Sequence[Observation], camera: CameraModel) -> None:
        """See ``MultiTracker``."""

    def update(self, observation: Observation) -> list[Track]:
        """See ``MultiTracker``."""
        self._places += self._rng.normal(0, 3, self._places.shape)
        return [Track(k, self.estimate(place)) for k, place in enumerate(self._places) if self._rng.random() < 0.8]

    def estimate(self, place: np.ndarray) -> Estimate:
        half = self._rng.uniform(0.5, 20, 2)
        box = np.concatenate([place - half, place + half])
        return Estimate(0.5 * (box[:2] + box[2:]), box)


class One:
    """See ``Tracker``."""

    def __init__(self, lot: Lot) -> None:
        self._lot = lot

    def initialise(self, observation: Observation, box_xyxy: np.ndarray) -> None:
        """See ``Tracker``."""
        self._place = 0.5 * (box_xyxy[:2] + box_xyxy[2:])

    def update(self, observation: Observation) -> Estimate:
        """See ``Tracker``."""
        rng = self._lot._rng
        self._place = self._place + rng.normal(0, 5, 2)
        said = self._lot.estimate(self._place)
        match rng.integers(8):
            case 0:
                return Estimate(np.full(2, np.nan))
            case 1:
                return replace(said, in_view_probability=float(rng.random()))
            case 2:
                return replace(said, box_xyxy=None)
        return said


class Masked(One):
    """Answers with a mask wherever it has a box in the picture, but not always."""

    def update(self, observation: Observation) -> Estimate:
        """See ``Tracker``."""
        said, size = super().update(observation), observation.image_rgb.shape[:2]
        mask = np.zeros(size, bool) if said.box_xyxy is None else Rectangle(said.box_xyxy).mask(*size)
        mask &= self._lot._rng.random(size) < 0.9
        return estimate_of(Mask(mask), *size) if mask.any() and self._lot._rng.random() < 0.8 else said


@dataclass(frozen=True, kw_only=True)
class DrawnMasks(Drawn):
    """A tracker of one target that answers with masks."""

    def create(
        self, named: EpisodeName, episode: Episode, rng: np.random.Generator, *, many: bool = False
    ) -> LoopTracker:
        """See ``TrackerSpec``."""
        camera = episode.start.camera
        lot = Lot(np.random.default_rng(self.draw + named.seed), camera.width_px, camera.height_px)
        return FromPictures(Masked(lot))


def _answered(experiment: Experiment, folder: Path, format: str) -> Path:
    """Run trackers with their estimates kept, and return the folder with the trackers' folders of predictions."""
    run(replace(experiment, keeper=Estimates()), folder / "run")
    write_predictions(folder / "run", format, str(folder / format))
    return folder / format / ("frameout-train" if format == "mot" else "")


def _numbers(folder: Path, *without: str) -> dict[Any, Any]:
    return {
        (
            row["tracker"],
            row["seed"],
            row["metric"],
            json.dumps([row.get(key) for key in ("frame_out", "gap", "link")]),
        ): (
            row["value"],
            row["weight"],
        )
        for row in read_rows(folder)
        if not row["metric"].startswith((*TIMES, *without))
    }


def _same(found: dict[Any, Any], wanted: dict[Any, Any]) -> None:
    assert found.keys() == wanted.keys()
    for key, (value, weight) in wanted.items():
        # Rows have six digits, of which the last may differ.
        np.testing.assert_allclose(np.array(found[key][0], float), np.array(value, float), rtol=2e-5, err_msg=str(key))
        assert found[key][1] == weight, key


@pytest.mark.filterwarnings("ignore:.*gave no answer")
@settings(
    max_examples=4, deadline=None, phases=[Phase.generate], suppress_health_check=[HealthCheck.function_scoped_fixture]
)
@given(draw=st.integers(0, 2**20), format=st.sampled_from(["vot", "mot"]))
def test_answers_written_and_scored_give_the_rows_of_their_run(
    draw: int, format: str, tmp_path_factory: pytest.TempPathFactory
) -> None:
    folder = tmp_path_factory.mktemp("frame-out")
    trackers = {"by_lot": Drawn(name="by_lot", draw=draw)}
    experiment = experiment_on(SUITE, "fake-town-v1", ["brief"], trackers, range(2, 4), workers=0)
    predictions = _answered(experiment, folder, format)
    score(SUITE, predictions=predictions, out=folder / "scored", workers=0)
    _same(_numbers(folder / "scored"), _numbers(folder / "run"))


@pytest.mark.filterwarnings("ignore:.*gave no answer")
def test_masks_written_and_scored_give_the_rows_of_their_run(tmp_path: Path) -> None:
    trackers = {"by_lot": DrawnMasks(name="by_lot", draw=3)}
    experiment = experiment_on(SUITE, "fake-town-v1", ["brief"], trackers, range(2, 4), workers=0)
    predictions = _answered(experiment, tmp_path, "vot")
    score(SUITE, predictions=predictions, out=tmp_path / "scored", workers=0)
    wanted = _numbers(tmp_path / "run")
    assert {value for (_, _, metric, _), (value, _) in wanted.items() if metric == "j_and_f"} - {0.0, None}
    _same(_numbers(tmp_path / "scored"), wanted)


@pytest.mark.heavy
@pytest.mark.parametrize("judging", ["fish", "many"])
def test_tracks_of_many_written_and_scored_give_the_rows_of_their_run(judging: str, tmp_path: Path) -> None:
    trackers = {"by_lot": Drawn(name="by_lot", draw=5)}
    predictions = _answered(
        experiment_on(judging, "fish-tank", ["few"], trackers, range(1), workers=0), tmp_path, "mot"
    )
    score(judging, predictions=predictions, preset="few", out=tmp_path / "scored", workers=0)
    _same(_numbers(tmp_path / "scored"), _numbers(tmp_path / "run"))


@pytest.fixture
def made(tmp_path: Path) -> Path:
    """Return a folder of predictions of two episodes by one who knows and one who stays, in VOT's format."""
    known = ["fake_knowing", "fake_still"]
    bench(SUITE, seeds=range(2), trackers=known, workers=0, out=tmp_path / "run", keep_estimates=True)
    write_predictions(tmp_path / "run", "vot", str(tmp_path / "vot"))
    for name in known:
        (tmp_path / "vot" / name).rename(tmp_path / "vot" / f"{name.removeprefix('fake_')}_there")
    return tmp_path


def test_they_stand_beside_trackers_that_ran_without_speed_and_posterior(made: Path) -> None:
    score(SUITE, predictions=made / "vot", out=made / "run", workers=0)
    numbers = _numbers(made / "run", *POSTERIOR)
    for name in ("knowing", "still"):
        there, here = (
            {key[1:]: value for key, value in numbers.items() if key[0] == tracker}
            for tracker in (f"{name}_there", f"fake_{name}")
        )
        _same(there, here)
    rows = [row for row in read_rows(made / "run") if row["tracker"] == "knowing_there"]
    assert not [row for row in rows if row["metric"] in TIMES]
    assert {row["value"] for row in rows if row["metric"].startswith(("coverage", "nees"))} == {None}
    assert {row["role"] for row in rows} == {"external"}


def test_the_folder_of_a_tracker_that_we_have_is_called_apart(made: Path) -> None:
    (made / "vot" / "still_there").rename(made / "vot" / "hold")
    results = score(SUITE, predictions=made / "vot", out=made / "scored", workers=0)
    assert set(results.rows()["tracker"]) == {"hold-elsewhere", "knowing_there"}


def test_folders_of_one_name_are_refused(made: Path) -> None:
    for name, other in (("still_there", "hold"), ("knowing_there", "hold-elsewhere")):
        (made / "vot" / name).rename(made / "vot" / other)
    with pytest.raises(ValueError, match="predictions: expected trackers of different names, got two called hold-else"):
        score(SUITE, predictions=made / "vot", out=made / "scored")
    with pytest.raises(ValueError, match="predictions: expected trackers of different names, got two called hold-else"):
        score(SUITE, predictions=[made / "vot" / "hold"] * 2, out=made / "scored")


def test_only_episodes_that_predictions_are_of_are_scored(made: Path) -> None:
    for path in [*(made / "vot").rglob("*-000001_001.txt")]:
        folder = path.parent.rename(path.parent.with_name(path.parent.name.replace("000001", "987654321")))
        (folder / path.name).rename(folder / path.name.replace("000001", "987654321"))
    results = score(SUITE, predictions=made / "vot", out=made / "scored", workers=0)
    assert set(results.rows()["seed"]) == {0, 987654321}
    assert not results.outcome.failed


def test_a_first_line_that_is_not_the_given_box_is_noted(made: Path) -> None:
    for path, facts in facts_in(made / "run").items():
        x0, y0, x1, y1 = read_block(path).answered[0].answers[0].box_xyxy
        lines = {"fake_knowing": f"{x0},{y0},{x1},{y1}\n", "fake_still": f"{x0},{y0},{x1 - x0},{y1 - y0}\n"}
        name = facts.key.tracker.replace("fake_", "")
        (file,) = (made / "vot" / f"{name}_there").rglob(f"*-{facts.key.seed:06d}_001.txt")
        file.write_text(lines[facts.key.tracker] + file.read_text().partition("\n")[2])
    with pytest.warns(TrackerWarning) as told:
        score(SUITE, predictions=made / "vot", out=made / "scored", workers=0)
    assert [str(each.message) for each in told] == [
        "knowing_there begins with another box than the given one (is it x1,y1,x2,y2 in place of "
        "left,top,width,height?), in 2 episodes"
    ]


def test_a_folder_with_more_seeds_tells_which_to_give(made: Path) -> None:
    for path in (made / "vot").rglob("*-000001_001.txt"):
        path.unlink()
    told = r"no seeds but 0:1, .*, or give --seeds 0:2 \(sequences without a file of predictions count as silence\)"
    with pytest.raises(ValueError, match=told):
        score(SUITE, predictions=made / "vot", out=made / "run", workers=0)
    with pytest.warns(TrackerWarning, match="expected a file for .*-000001, got none"):
        score(SUITE, predictions=made / "vot", out=made / "run", seeds=range(2), workers=0)


def test_only_changed_files_are_scored_again(made: Path) -> None:
    out: dict[str, Any] = {"out": made / "scored", "workers": 0}
    first = score(SUITE, predictions=made / "vot", **out)
    assert first.rows().query("metric == 'silent_frames'")["value"].sum() == 0
    again = score(SUITE, predictions=made / "vot", **out)
    path = next((made / "vot" / "still_there").rglob("*-000001_001.txt"))
    path.write_text(path.read_text().replace("\n", "\r\n"))
    unchanged = score(SUITE, predictions=made / "vot", **out)
    path.write_text("1\n" + "0\n" * (FRAMES - 1))
    with pytest.warns(TrackerWarning, match=f"still_there gave no answer .* on {FRAMES - 1} frames"):
        changed = score(SUITE, predictions=made / "vot", **out)
    done = [(each.outcome.episodes, each.outcome.resumed) for each in (first, again, unchanged, changed)]
    assert done == [(4, 0), (0, 4), (0, 4), (1, 3)]
    assert changed.rows().query("metric == 'silent_frames'")["value"].sum() == FRAMES - 1


def test_a_sequence_without_predictions_is_named_and_scored_as_silence(made: Path) -> None:
    next((made / "vot" / "knowing_there").rglob("*-000001_001.txt")).unlink()
    wanted = (
        "knowing_there failed in fake-town-v1 brief, seed 1, frame 0: .* expected a file for .*-brief-000001, got none"
    )
    with pytest.warns(TrackerWarning, match=wanted):
        results = score(SUITE, predictions=made / "vot", out=made / "scored", workers=0)
    assert results.outcome.failed
    rows = results.rows()
    assert set(rows[rows["tracker"] == "knowing_there"]["seed"]) == {0, 1}


@pytest.mark.heavy
def test_detections_and_one_track_of_many_follow_the_target(made: Path) -> None:
    """The same boxes as JSON without and with identities, and as rows beside those of another car."""
    lines = {path.stem.removesuffix("_001"): path for path in (made / "vot" / "knowing_there").rglob("*_001.txt")}
    images, results = [], []
    for name, path in lines.items():
        rows = []
        for frame, line in enumerate(path.read_text().splitlines()):
            images.append({"id": len(images) + 1, "file_name": f"{name}/{frame:06d}.png"})
            if "," in line:
                left, top, *size = map(float, line.split(","))
                found = {"image_id": len(images), "category_id": 1, "bbox": [left, top, *size], "score": 1.0}
                results += [found, found | {"bbox": [0, 0, 5, 5], "score": 0.2}]
                rows += [f"{frame + 1},5,{left + 1!r},{top + 1!r},{size[0]!r},{size[1]!r},1"]
                rows += [f"{frame + 1},9,400,400,5,5,1"]
        (made / "mot" / "rows").mkdir(parents=True, exist_ok=True)
        (made / "mot" / "rows" / f"{name}.txt").write_text("\n".join(rows))
    (made / "all.json").write_text(json.dumps({"images": images}))
    for name, some in (("coco", results), ("tao", [each | {"track_id": 4} for each in results[::2]])):
        (made / "json" / name).mkdir(parents=True)
        (made / "json" / name / "results.json").write_text(json.dumps(some))
    how: dict[str, Any] = {"out": made / "scored", "workers": 0}
    score(SUITE, predictions=[made / "vot", made / "mot"], **how)
    score(SUITE, predictions=made / "json", annotations=made / "all.json", **how)
    numbers = _numbers(made / "scored", *POSTERIOR, "in_view_t", "precision_curve", "recall_curve")
    by_tracker = {
        tracker: {key[1:]: value for key, value in numbers.items() if key[0] == tracker}
        for tracker in ("knowing_there", "rows", "coco", "tao")
    }
    for tracker in ("rows", "coco", "tao"):
        _same(by_tracker[tracker], by_tracker["knowing_there"])


@pytest.mark.heavy
def test_the_command_prints_a_leaderboard_and_its_report_names_it(
    made: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("benchmarks.cli.score_function.registry.suite", lambda name: SUITE)
    words = ["score", "--predictions", str(made / "vot"), "--out", str(made / "scored"), "--workers", "0"]
    assert main(words) == 0
    assert "knowing_there" in capsys.readouterr().out
    page = (made / "scored" / "report.html").read_text()
    assert f"frameout score frame-out --truth fake-town-v1 --preset brief --seeds 0:2 --predictions {made}/vot" in page
    assert main(["compare", "knowing_there", "still_there", "--directory", str(made / "scored")]) == 0


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ([], "predictions: expected a folder or several, got none"),
        (["--predictions", "nix"], "predictions: expected folders that exist, got 'nix'"),
        (["follow", "--predictions", "."], "suite: expected one of .*, got follow, whose camera no prediction steers"),
        (
            ["harbour", "--predictions", "."],
            "suite: expected one of .*fish.*, got harbour, which scores tracks with depth_m",
        ),
        (["fish", "--predictions", ".", "--real", "x"], "suite: expected one that judges real pictures .*, got fish"),
        (
            ["--predictions", ".", "--truth", "nix"],
            "truth: expected one of road-town-v2.*, or the folder of a data set",
        ),
        (["--predictions", ".", "--preset", "nix"], "preset: expected one of .*; got 'nix'"),
        (["--predictions", ".", "--format", "nix"], "format: expected one of vot, otb, mot, mots, coco, got 'nix'"),
        (["--predictions", "."], r"predictions: expected NAME\.txt, .*, got nothing"),
        (["--predictions", ".", "--real", ".", "--seeds", "1"], "seeds: expected none with real"),
    ],
)
def test_wrong_arguments_are_named(
    words: list[str], message: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["score", *words]) == 2
    assert re.search(message, capsys.readouterr().err)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"predictions": []}, "predictions: expected a folder or several, got none"),
        ({"seeds": 3}, r"seeds: expected range\(A, B\), or None, got 3"),
        ({"suite": ["frame-out"]}, "suite: expected a name or a Suite"),
    ],
)
def test_wrong_arguments_from_python_are_named(given: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        score(**{"predictions": "."} | given)


def test_files_for_one_target_are_refused_in_a_suite_of_many(tmp_path: Path) -> None:
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "fish-tank-v1-few-000000.txt").write_text("1\n" * 40)
    with pytest.raises(ValueError, match=r"000\.txt: expected tracks with identities .*, got a line a frame"):
        score("fish", predictions=tmp_path / "mine", preset="few", out=tmp_path / "out")
    assert not (tmp_path / "out").exists()


def _real(folder: Path) -> Path:
    """Write a sequence of OTB whose target is seen from the fourth picture on, and a tracker's lines for all of it."""
    boxes = true_boxes(30)
    boxes[:3] = np.nan
    write_otb(folder / "Red", boxes)
    moved = boxes + np.array([1.0, 1.0, 3.0, 3.0])
    write_lines(folder / "predictions" / "mine" / "Red.txt", lines_of(moved))
    return folder


@pytest.mark.filterwarnings("ignore:.*gave no answer")
@pytest.mark.filterwarnings("ignore:.* begins with another box")
def test_real_sequences_are_scored_from_their_first_picture_on_or_from_the_target_s(tmp_path: Path) -> None:
    folder = _real(tmp_path)
    lines = (folder / "predictions" / "mine" / "Red.txt").read_text().splitlines()
    write_lines(folder / "predictions" / "cut" / "Red.txt", lines[3:])
    rows = [f"{k},1,{line},1" for k, line in enumerate(lines, start=1) if "NaN" not in line]
    write_lines(folder / "predictions" / "mot" / "data" / "Red.txt", rows)
    how: dict[str, Any] = {"real": folder / "Red", "out": folder / "scored", "workers": 0}
    score(predictions=[folder / "predictions" / name for name in ("mine", "cut")], format="otb", **how)
    results = score(predictions=folder / "predictions" / "mot", **how)
    rows_of = results.rows()
    assert set(rows_of["sequence"]) == {"Red"}
    numbers = _numbers(folder / "scored")
    mine, cut, mot = ({k[1:]: v for k, v in numbers.items() if k[0] == name} for name in ("mine", "cut", "mot"))
    # The answer on the first picture is the given box; on the others corners are 1 and 3 px off.
    errors = rows_of[(rows_of["metric"] == "centre_error_px") & (rows_of["tracker"] == "mine")]
    seen = 30 - 3 - len(range(15, 20))
    assert errors["value"].to_list() == [pytest.approx(np.hypot(2, 2) * (seen - 1) / seen, rel=1e-5)]
    _same(cut, mine)
    # Confidences of 1, and none, are the same where the answer is in the picture.
    _same(mot, mine)


@pytest.mark.filterwarnings("ignore:.*gave no answer")
@pytest.mark.parametrize(
    ("write", "file"),
    [
        (write_coco, "annotations/instances.json"),
        (write_tao, "annotations/validation.json"),
        (write_tao_amodal, "amodal_annotations/validation.json"),
    ],
)
def test_results_on_the_pictures_of_real_annotations(tmp_path: Path, write: Callable[[Path], Path], file: str) -> None:
    """Of TAO not every picture is named."""
    annotations = write(tmp_path / "set") / file
    seen = [each for each in json.loads(annotations.read_text())["annotations"] if min(each["bbox"][2:]) > 0]
    keys = ("image_id", "category_id", "bbox", "track_id")
    results = [{key: each[key] for key in keys if key in each} | {"score": 0.9} for each in seen]
    write_lines(tmp_path / "mine" / "results.json", [json.dumps(results)])
    how: dict[str, Any] = {"predictions": tmp_path / "mine", "out": tmp_path / "scored", "workers": 0}
    rows = score(real=tmp_path / "set", annotations=annotations, **how).rows()
    assert rows.set_index("metric")["value"]["in_view_tpr"] == 1.0
    other = annotations.with_name("other.json")
    other.write_text(annotations.read_text().replace(".png", ".gif").replace(".jpg", ".gif"))
    with pytest.raises(ValueError, match=r"results\.json: expected \d pictures of .* in its annotations, got 0"):
        score(real=tmp_path / "set" / file, annotations=other, **how)


@pytest.mark.parametrize("format", ["mot", "vot"])
def test_answers_on_real_pictures_have_the_numbers_of_their_files(tmp_path: Path, format: str) -> None:
    """The target is first seen in the fourth picture."""
    folder = _real(tmp_path)
    how: dict[str, Any] = {"real": folder / "Red", "workers": 0}
    bench(trackers=["correlation_filter"], out=tmp_path / "run", keep_estimates=True, **how)
    write_predictions(tmp_path / "run", format, str(tmp_path / format))
    predictions = tmp_path / format / ("frameout-train" if format == "mot" else "")
    score(predictions=predictions, out=tmp_path / "scored", **how)
    there, here = ({key[1:]: value for key, value in _numbers(tmp_path / each).items()} for each in ("scored", "run"))
    _same(there, here)
    (folder / "Red" / "groundtruth_rect.txt").unlink()
    if format == "mot":
        with pytest.raises(ValueError, match="estimates: expected the pictures of Red, whose numbers rows of MOT have"):
            write_predictions(tmp_path / "run", format, str(tmp_path / "again"))


def test_answers_on_two_sequences_of_one_name_are_not_written(tmp_path: Path) -> None:
    for name in ("first", "other"):
        for each in ("Red", "Blue"):
            write_otb(tmp_path / name / each, true_boxes(6))
    real = [tmp_path / "first", tmp_path / "other"]
    bench(real=real, trackers=["hold"], out=tmp_path / "run", workers=0, keep_estimates=True)
    with pytest.raises(ValueError, match=r"estimates: expected sequences of different names, as .* two called Blue"):
        write_predictions(tmp_path / "run", "vot", str(tmp_path / "out"))
    assert not (tmp_path / "out").exists()


def test_lines_of_another_number_of_pictures_are_refused(tmp_path: Path) -> None:
    folder = _real(tmp_path)
    write_lines(folder / "predictions" / "mine" / "Red.txt", ["1,1,2,2"] * 29)
    with pytest.raises(ValueError, match=r"mine/Red\.txt: expected 30 lines, one a frame of Red, got 29"):
        score(predictions=folder / "predictions", real=folder / "Red", out=folder / "scored")


@pytest.mark.heavy
def test_trackeval_scores_written_rows_as_the_identity_metrics_do(tmp_path: Path) -> None:
    """On boxes: TrackEval reads the rows of trackers and of truth; ours pairs the same boxes by their overlap."""
    data = tmp_path / "set"
    assert (
        main(["generate", "fish-tank", "--preset", "few", "--seeds", "0:1", "--out", str(data), "--workers", "0"]) == 0
    )
    trackers = ["sort", "shoal_chain"]
    bench(
        "fish", data=str(data), seeds=range(1), trackers=trackers, workers=0, out=tmp_path / "run", keep_estimates=True
    )
    write_predictions(tmp_path / "run", "mot", str(tmp_path / "answers"))
    export(DataSet(str(data)), "mot", tmp_path / "truth")
    quiet = {"PRINT_CONFIG": False, "PRINT_RESULTS": False, "TIME_PROGRESS": False, "OUTPUT_SUMMARY": False}
    evaluator = trackeval.Evaluator(quiet | {"PLOT_CURVES": False, "OUTPUT_DETAILED": False, "LOG_ON_ERROR": None})
    folders = {"GT_FOLDER": str(tmp_path / "truth/gt/mot_challenge"), "TRACKERS_FOLDER": str(tmp_path / "answers")}
    kind = trackeval.datasets.MotChallenge2DBox(
        folders | {"BENCHMARK": "frameout", "DO_PREPROC": False, "PRINT_CONFIG": False}
    )
    metrics = trackeval.metrics
    chosen = [metric({"PRINT_CONFIG": False}) for metric in (metrics.HOTA, metrics.CLEAR, metrics.Identity)]
    results, _ = evaluator.evaluate([kind], chosen)
    name = "fish-tank-v1-few-000000"
    truth = read_mot(tmp_path / f"truth/gt/mot_challenge/frameout-train/{name}/gt/gt.txt")
    for tracker in trackers:
        found = read_mot(tmp_path / f"answers/frameout-train/{tracker}/data/{name}.txt")
        frames = numbered(
            [
                Pairing(
                    truth.identity[truth.frame == k],
                    found.identity[found.frame == k],
                    intersections_over_union(truth.box_xyxy[truth.frame == k], found.box_xyxy[found.frame == k]),
                )
                for k in range(1, 41)
            ]
        )
        theirs = results["MotChallenge2DBox"][tracker][name]["pedestrian"]
        assert hota(frames) == pytest.approx(theirs["HOTA"]["HOTA"].mean())
        assert identity_counts(frames).idf1 == pytest.approx(theirs["Identity"]["IDF1"])
        assert clear_counts(frames).mota == pytest.approx(theirs["CLEAR"]["MOTA"])
        assert theirs["HOTA"]["HOTA"].mean() > 0.3


@pytest.mark.filterwarnings("ignore:.*gave no answer")
@pytest.mark.heavy
def test_an_exported_set_is_the_truth_of_predictions(tmp_path: Path) -> None:
    """The true boxes of each export, as predictions of COCO and TAO, are right wherever the target is seen."""
    data = tmp_path / "set"
    words = ["generate", "road-town", "--preset", "quick", "--seeds", "0:1", "--out", str(data), "--workers", "0"]
    assert main(words) == 0
    for format in ("coco", "tao-amodal"):
        export(DataSet(str(data)), format, tmp_path / format)
    files = {"coco": "annotations/instances.json", "tao-amodal": "amodal_annotations/validation.json"}
    for format, file in files.items():
        annotated = json.loads((tmp_path / format / file).read_text())
        results = [
            {key: each[key] for key in ("image_id", "category_id", "bbox", "track_id") if key in each} | {"score": 1.0}
            for each in annotated["annotations"]
            if each["attributes"]["role"] == "target" and min(each["bbox"][2:]) > 0
        ]
        write_lines(tmp_path / "json" / format / "results.json", [json.dumps(results)])
        how = {"annotations": tmp_path / format / file, "out": tmp_path / "scored", "workers": 0}
        found = score(truth=str(data), predictions=tmp_path / "json" / format, **how)
        rows = found.rows()
        rows = rows[rows["tracker"] == format].set_index("metric")["value"]
        assert rows["in_view_tpr"] == 1.0
        assert rows["in_view_tnr"] == 1.0
        assert rows["success_auc"] > 0.9
