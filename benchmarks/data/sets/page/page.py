"""One self-contained HTML page about a data set: what it is, what it looks like, what happens in it."""

from __future__ import annotations

import base64
import dataclasses
import math
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
from markupsafe import Markup

from benchmarks.contract.text import ranges_text
from benchmarks.data.sets.channels import NORMALS, coding_of
from benchmarks.data.sets.data_set import DataSet
from benchmarks.data.sets.page import figures, scans
from benchmarks.data.sets.page.sheets import Shot, boxed_shots, channel_shots
from benchmarks.data.sets.page.statistics import by_group, check_episodes, state_shares
from benchmarks.show.page import page_environment, page_style
from benchmarks.show.plots import Plot
from scenarios import catalog
from scenarios.truth import meanings

PAGE = "page.html"
"""Name of the page in a data set's folder."""
_QUALITY = 86
_UNITS = ("B", "kB", "MB", "GB", "TB")
_SAID = {
    "image_rgb": "the picture, red, green, blue",
    "right_rgb": "the right picture of a stereo pair",
    "counts": "raw counts of a thermal camera",
    NORMALS: "unit vectors of surfaces, world frame; 0 where there is none",
    "tables": "all else: truth of frames and objects, and the places of channels",
}
"""What is stored besides maps of truth, which tell it themselves."""
_WORDS = 10
"""Most frequent words that are shown."""
_OBJECTS_SHARE, _FRAMES_SHARE = "share of objects", "share of frames"


@dataclass(frozen=True, slots=True)
class Picture:
    """A picture as the page shows it; ``source`` is its data URL."""

    title: str
    words: str
    source: str
    width_px: int
    height_px: int


def render_page(data: DataSet) -> str:
    """Return the page. Raises ValueError if the data set has no episode."""
    check_episodes(data)
    request = data.request
    scenario = catalog.scenario(request.scenario)
    frames = len(data)
    stored = data.stored_bytes()
    first = data.episode(data.seeds[0])
    camera = first.camera
    quantities, constants = _scene(data)
    template = page_environment(__file__).get_template("page.html.jinja")
    style = page_style() + Path(__file__).with_name("page.css").read_text()
    return template.render(
        style=Markup(style),
        heading=f"{request.scenario} · {request.preset}",
        summary=scenario.summary,
        preset=scenario.presets[request.preset].summary,
        episodes=_episodes_text(data),
        frames=frames,
        rate_hz=first.rate_hz,
        camera=camera,
        size=bytes_text(sum(stored.values())),
        shots=[[_picture(shot) for shot in row] for row in boxed_shots(data)],
        target=scenario.target,
        channels=[_picture(shot) for shot in channel_shots(data)],
        seen=_seen_text(data),
        events=list(_events(data)),
        quantities=quantities,
        constants=constants,
        stored=list(_stored_rows(data, stored, frames)),
        request={name: _text(name, value) for name, value in dataclasses.asdict(request).items()},
    )


def bytes_text(count: float) -> str:
    """Return a number of bytes in words, ``12.3 MB``."""
    power = min(int(math.log10(max(count, 1)) // 3), len(_UNITS) - 1)
    return f"{count / 1000**power:.{0 if power == 0 else 1}f} {_UNITS[power]}"


def _picture(shot: Shot) -> Picture:
    _, coded = cv2.imencode(".jpg", shot.image_rgb[..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, _QUALITY])
    source = f"data:image/jpeg;base64,{base64.b64encode(coded.tobytes()).decode()}"
    height, width = shot.image_rgb.shape[:2]
    return Picture(shot.title, shot.words, source, width, height)


def _episodes_text(data: DataSet) -> str:
    missing = sorted(set(range(*data.request.seeds)) - set(data.seeds))
    text = f"{len(data.seeds):,} episode{'s' if len(data.seeds) > 1 else ''} · seeds {ranges_text(data.seeds)}"
    return f"{text} · not written: {ranges_text(missing)}" if missing else text


def _seen_text(data: DataSet) -> str:
    """Return how many objects of frames are seen, by kind and group, in words."""
    told = (
        f"{kind}: " + ", ".join(f"{count:,} {group}" for group, count in groups.items())
        for kind, groups in scans.seen_counts(data).items()
    )
    return "; ".join(told) or "none"


def _events(data: DataSet) -> Iterator[Plot]:
    """Yield the figures about objects: states, frame-outs, sizes, what is seen of them."""
    shares = figures.draw_shares(state_shares(data), _OBJECTS_SHARE)
    words = "In view; cut by the border; inside but less than half visible; outside; not in the world."
    yield Plot("States", words, shares)
    outs = scans.frame_outs(data)
    if outs:
        lengths = {group: each.lengths.astype(float) for group, each in outs.items()}
        told = "; ".join(
            f"{group}: {len(each.lengths):,}, of which {each.unfinished:,} last to the end"
            for group, each in outs.items()
        )
        svg = figures.draw_histogram(lengths, "frames out of the picture", "share of frame-outs")
        yield Plot("Lengths of frame-outs", f"Runs of the state out, after having been in the picture. {told}.", svg)
    sides = scans.box_sides_px(data)
    if sides:
        svg = figures.draw_histogram(sides, "side of the visible box, px", _OBJECTS_SHARE)
        yield Plot("Sizes in the picture", f"Root of width × height. {_median_text(sides, ' px')}.", svg)
    fractions = scans.visible_fractions(data)
    if fractions:
        svg = figures.draw_histogram(fractions, "visible fraction", _OBJECTS_SHARE, (0.0, 1.0))
        yield Plot("What is seen of them", "Share of an object's own pixels, while it is not outside.", svg)


def _scene(data: DataSet) -> tuple[list[Plot], dict[str, str]]:
    """Return a figure for each number or word of the scene's truth that changes, and in words flags and all others."""
    plots, told = [], {}
    for each in scans.quantities(data):
        share = _FRAMES_SHARE if each.table == "frames" else _OBJECTS_SHARE
        if each.kind == "word":
            counts = scans.words(data, each)
            if len(counts) == 1:
                told[each.name] = next(iter(counts))
                continue
            total = sum(counts.values())
            shares = {word: count / total for word, count in list(counts.items())[:_WORDS]}
            plots.append(Plot(each.name, "", figures.draw_shares({"": shares}, f"{share}, by {each.name}")))
            continue
        values = scans.numbers(data, each)
        if each.kind == "flag":
            told[each.name] = _flag_text(values)
        elif _varies(values):
            label = each.name if each.unit == "1" else f"{each.name}, {each.unit}"
            plots.append(Plot(each.name, f"{_median_text(values)}.", figures.draw_histogram(values, label, share)))
        elif values:
            unit = "" if each.unit == "1" else f" {each.unit}"
            told[each.name] = f"{_number(next(iter(values.values()))[0])}{unit} throughout"
    return plots, told


def _flag_text(values: scans.ByGroup) -> str:
    return "; ".join(f"{_of(group)}true in {100 * each.mean():.1f} %" for group, each in values.items())


def _of(group: str) -> str:
    return f"{group}: " if group else ""


def _varies(values: scans.ByGroup) -> bool:
    ends = [end for each in values.values() for end in (each.min(), each.max())]
    return bool(ends) and max(ends) > min(ends)


def _median_text(values: scans.ByGroup, unit: str = "") -> str:
    medians = by_group(values)
    return "; ".join(f"{_of(group)}median {_number(each['median'])}{unit}" for group, each in medians.items())


def _number(value: float) -> str:
    return (f"{value:,.0f}" if abs(value) >= 1000 else f"{value:.3g}").replace("-", "−")


def _stored_rows(data: DataSet, stored: dict[str, int], frames: int) -> Iterator[tuple[str, ...]]:
    """Yield name, coding, meaning, bytes a frame and share of each channel."""
    known = meanings(catalog.scenario(data.request.scenario).truth)
    total = max(sum(stored.values()), 1)
    for name, count in stored.items():
        coding = coding_of(name, data.request.pictures) if name in data.request.channels else "Parquet"
        meaning = known.get(name)
        said = "" if meaning is None else "; ".join(filter(None, (meaning.unit, meaning.coding)))
        yield name, coding, bytes_text(count / frames), f"{100 * count / total:.1f} %", _SAID.get(name, said)


def _text(name: str, value: Any) -> str:
    if value is None:
        return "as in the preset"
    if isinstance(value, dict):
        return ", ".join(f"{key} {each}" for key, each in value.items()) or "–"
    if isinstance(value, tuple):
        return (":" if name == "seeds" else ", ").join(map(str, value))
    return str(value) or "–"
