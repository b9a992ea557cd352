"""Errors of the way to a store, and others."""

from __future__ import annotations

import pytest

from benchmarks.data.sets.places import reached


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
