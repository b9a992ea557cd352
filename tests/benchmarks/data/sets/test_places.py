"""The same bytes from a cluster and on a store, and what is said when they are not there."""

from __future__ import annotations

from urllib.request import Request, urlopen

import pytest

from benchmarks.data.exports.exporter import export
from benchmarks.data.sets.data_set import DataSet
from benchmarks.data.sets.generating import Workers
from benchmarks.data.sets.places import place_of, reached
from benchmarks.data.sets.verifying import problems
from tests.benchmarks.data.sets.small import MODULES, made, tiny
from tests.benchmarks.data.sets.test_generating import digests


@pytest.mark.heavy
@pytest.mark.filterwarnings("ignore")
def test_two_workers_of_a_cluster_make_the_same_bytes(data, tmp_path):
    distributed = pytest.importorskip("distributed")
    with distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster:
        made(tiny(), tmp_path / "set", Workers(2, cluster.scheduler_address, MODULES))
    assert digests(tmp_path / "set") == digests(data.root)


@pytest.mark.heavy
@pytest.mark.filterwarnings("ignore")
def test_a_cluster_that_does_not_answer_is_named_and_leaves_no_folder(tmp_path, monkeypatch):
    pytest.importorskip("distributed")
    monkeypatch.setattr("benchmarks.data.sets.generating._PATIENCE_S", 1.0)
    with pytest.raises(
        ValueError, match=r"address: expected a Dask scheduler that answers, got 'tcp://127\.0\.0\.1:9'"
    ):
        made(tiny(), tmp_path / "set", Workers(1, "tcp://127.0.0.1:9"))
    assert not (tmp_path / "set").exists()


@pytest.fixture
def bucket(monkeypatch):
    """Run an S3 server of this machine with a bucket called ``bucket``."""
    server = pytest.importorskip("moto.server")
    s3fs = pytest.importorskip("s3fs")
    settings = {"AWS_ACCESS_KEY_ID": "a", "AWS_SECRET_ACCESS_KEY": "b", "AWS_DEFAULT_REGION": "us-east-1"}
    for name, value in settings.items():
        monkeypatch.setenv(name, value)
    store = server.ThreadedMotoServer(ip_address="127.0.0.1", port=0)
    store.start()
    try:
        _, port = store.get_host_and_port()
        monkeypatch.setenv("AWS_ENDPOINT_URL", f"http://127.0.0.1:{port}")
        # Servers of one process share what they hold.
        urlopen(Request(f"http://127.0.0.1:{port}/moto-api/reset", method="POST")).close()
        files = s3fs.S3FileSystem(skip_instance_cache=True)
        files.mkdir("bucket")
        yield files
    finally:
        store.stop()
        s3fs.S3FileSystem.clear_instance_cache()


@pytest.mark.heavy
@pytest.mark.filterwarnings("ignore")
def test_a_set_on_an_s3_store_has_the_same_contents(data, bucket, tmp_path, monkeypatch):
    stored = made(tiny(), "s3://bucket/set")
    assert {seed: stored.episode(seed).marks for seed in stored.seeds} == {
        seed: data.episode(seed).marks for seed in data.seeds
    }
    assert list(problems(DataSet("s3://bucket/set"), lambda done, of: None)) == []
    assert stored[13].truth.time_s == data[13].truth.time_s
    export(DataSet("s3://bucket/set"), "webdataset", "s3://bucket/exports/web")
    export(data, "webdataset", tmp_path / "web")
    names = {path.name for path in (tmp_path / "web").iterdir()}
    assert {path.rpartition("/")[2] for path in bucket.find("bucket/exports/web")} == names
    for name in names:
        assert bucket.cat_file(f"bucket/exports/web/{name}") == (tmp_path / "web" / name).read_bytes()

    for write in (lambda url: made(tiny(), url), lambda url: export(data, "webdataset", url)):
        with pytest.raises(
            ValueError, match="out: expected a bucket that exists, got 's3://bukcet/x' without a bucket"
        ):
            write("s3://bukcet/x")
    assert bucket.ls("") == ["bucket"]

    monkeypatch.setenv("AWS_ENDPOINT_URL", "http://127.0.0.1:9")
    type(bucket).clear_instance_cache()
    reaching = {
        "out": (lambda url: made(tiny(), url), lambda url: export(data, "webdataset", url)),
        "directory": (DataSet,),
    }
    for parameter, calls in reaching.items():
        for call in calls:
            with pytest.raises(ValueError, match=rf"^{parameter}: expected a store that can be reached, got [^\n]*$"):
                call("s3://bucket/other")


@pytest.mark.heavy
@pytest.mark.filterwarnings("ignore")
def test_a_set_grows_on_an_s3_store_and_a_failed_export_leaves_the_bucket_to_others(bucket, monkeypatch):
    made(tiny(seeds=(3, 4)), "s3://bucket/set")
    grown = made(tiny(), "s3://bucket/set")
    assert grown.is_listed
    assert [entry.seed for entry in grown.entries()] == [3, 4]
    bucket.mkdir("empty")
    store, _ = place_of("s3://empty")
    put = store.put_file

    def fail(source, target):
        if target.endswith("README.md"):
            bucket.pipe_file("empty/theirs.txt", b"theirs")
            raise ConnectionError("lost")
        put(source, target)

    with monkeypatch.context() as patch:
        patch.setattr(store, "put_file", fail)
        with pytest.raises(ValueError, match=r"out: expected a store that can be reached, got 's3://empty' \(lost\)"):
            export(grown, "webdataset", "s3://empty")
    bucket.invalidate_cache()
    assert bucket.find("empty") == ["empty/theirs.txt"]
    bucket.rm_file("empty/theirs.txt")
    export(grown, "webdataset", "s3://empty")
    assert bucket.exists("empty/README.md")


def raised(error: Exception, url: str) -> Exception:
    """Return what comes of an error on the way to a place."""
    with pytest.raises(type(error)) as found, reached(url, "out"):
        raise error
    return found.value


@pytest.mark.parametrize("error", [ChildProcessError("a worker ended"), FileNotFoundError("nix"), KeyError("a bug")])
def test_what_is_not_of_the_way_to_a_store_stays_what_it_is(error: Exception) -> None:
    assert raised(error, "memory://set") is error


def test_a_store_that_is_not_reached_is_named() -> None:
    told = r"^out: expected a store that can be reached, got 'memory://set' \(lost\)$"
    with pytest.raises(ValueError, match=told), reached("memory://set", "out"):
        raise ConnectionError("lost")
    assert isinstance(raised(OSError("disk"), "/tmp/set"), OSError)
