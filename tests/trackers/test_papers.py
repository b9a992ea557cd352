"""The references of the papers stand in one place, and every method as written names its own."""

from __future__ import annotations

import pytest

from trackers import registry
from trackers.papers import PAPERS, Paper, paper_of

AS_WRITTEN = [
    each
    for each in registry.entries().values()
    if each.role == "as-written" and each.tracker.__module__.startswith("trackers.")
]


def test_there_are_four_and_each_has_methods() -> None:
    assert list(PAPERS) == ["A", "B", "C", "D"]
    assert {paper_of(each.tracker.__module__) for each in AS_WRITTEN} == set(PAPERS.values())


@pytest.mark.parametrize("entry", AS_WRITTEN, ids=lambda entry: entry.name)
def test_a_method_as_written_names_its_paper_where_it_is_described(entry: registry.TrackerEntry) -> None:
    paper = paper_of(entry.tracker.__module__)
    assert paper is not None
    words = " ".join((entry.tracker.__doc__ or "").split())
    named = [author.split()[-1] for author in paper.authors]
    years = paper.date.split()[-1:] if named else []
    source = f" ({', '.join(named)} {years[0]})" if named else ""
    assert f"Source: {paper.name}{source}, see ``trackers.papers``." in words
    assert paper.name in entry.summary


def test_other_methods_have_none() -> None:
    ours = [each for each in registry.entries().values() if each.role in ("ours", "baseline")]
    assert {paper_of(each.tracker.__module__) for each in ours} == {None}


def test_a_reference_says_what_is_known_and_what_is_not() -> None:
    assert PAPERS["A"].reference() == (
        "Ryuji Nawata, Norikazu Ikoma, Hideaki Kawano, Hiroshi Maeda. “Robust visual tracking using background "
        "information in dynamic image including out-of-field-of-view”. IPSJ SIG Technical Report, Vol. 2010-CVIM-171 "
        "No. 10, Information Processing Society of Japan. 18 March 2010."
    )
    assert PAPERS["B"].reference() == "Not on the copy at hand: authors, title, place."
    assert PAPERS["C"].reference().endswith("5ZG-07, p. 4-527. 2023. Not on the copy at hand: authors, title.")
    assert Paper("E", "none", "nothing", ("An Author",), "A title", "A journal", "2020").reference().endswith("2020.")
