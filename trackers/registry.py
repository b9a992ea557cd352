"""The registry of trackers, by name.

A tracker registers where it is defined::

    @dataclass(frozen=True)
    class ColourParameters:
        particles: int = 500
        colour_sharpness: float = tunable(20.0, 1.0, 200.0, log=True)

    @register("colour_pf", role="as-written", summary="plain colour particle filter")
    class ColourParticleFilter:
        Parameters = ColourParameters
        def __init__(self, parameters: ColourParameters, rng: np.random.Generator): ...

Values found by tuning lie in ``trackers/tuned/NAME.json`` (written by ``frameout tune``) and take the place of the
defaults. A paper's method keeps the values as written: where tuning found better ones, it stands a second time, as
``NAME_tuned``. So does any method if that file has the key ``kept_as_written``, with the reason.
"""

from __future__ import annotations

import dataclasses
import difflib
import importlib
import json
import sys
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, TypeVar, get_args

import numpy as np

from trackers.follow_one import FollowOne
from trackers.protocols import Tracker
from trackers.types import Observation, SiteSurvey

Role = Literal["ours", "variant", "as-written", "tuned", "baseline", "blind", "oracle", "external"]

_MODULES = {
    "trackers.baselines.single_target": ("hold", "constant_velocity", "opencv_mil"),
    "trackers.baselines.ground_followers": ("hold_ground", "constant_velocity_ground", "template_ground"),
    "trackers.baselines.opencv_contrib": ("opencv_csrt",),
    "trackers.baselines.panorama_difference": ("panorama_difference",),
    "trackers.correlation_filter.tracker": ("correlation_filter",),
    "trackers.baselines.sort": ("sort",),
    "trackers.baselines.sort_appearance": ("sort_appearance",),
    "trackers.baselines.bytetrack": ("bytetrack",),
    "trackers.road_shape.colour_pf": ("colour_pf",),
    "trackers.road_shape.road_shape_pf": ("road_shape_pf",),
    "trackers.road_shape.background_pf": ("background_pf",),
    "trackers.mosaic_graph.tracker": ("mosaic_graph_pf",),
    "trackers.light_adaptive_stereo.stereo_colour": ("stereo_wb", "stereo_wb_shutter_gain"),
    "trackers.baselines.stereo_gate": ("stereo_nearest", "stereo_colour_gate"),
    "trackers.stereo_people.tracker": ("stereo_people",),
    "trackers.fish_chain.tracker": ("shoal_chain",),
    "trackers.gap_kalman.ca_kalman": ("ca_kalman",),
    "trackers.blind.dead_reckoning": ("blind_carried", "blind_straight", "blind_turning", "blind_below", "blind_ahead"),
    "trackers.baselines.gap_methods": (
        "fish_hold",
        "fish_constant_velocity",
        "fish_damped_velocity",
        "fish_linear",
        "fish_hermite",
    ),
    "trackers.blind.gap_places": ("fish_mean_place", "fish_middle", "fish_wall_ahead"),
    "trackers.harbour_watch.tracker": ("harbour_watch",),
    "trackers.eigen_swarm.tracker": ("eigen_swarm",),
    "trackers.eigen_swarm.learnt_confidence": ("eigen_swarm_learnt_confidence",),
    "trackers.baselines.ground_foreground": ("harbour_mog2", "harbour_knn", "harbour_median"),
    "trackers.blind.harbour_blind": ("harbour_blind", "harbour_posts"),
}
"""Module -> names of the trackers that it registers, in the order of ``entries``. A variant stands in the module of the
tracker whose name its own begins with, and needs no entry. Add yours here.
"""
_HOMES = {name: module for module, names in _MODULES.items() for name in names}

OWN_NEEDS_MODULE = "; one of your own is known when its module is imported"
"""Clause of the error about an unknown name."""
_ENTRIES: dict[str, TrackerEntry] = {}
_T = TypeVar("_T", bound=type)


@dataclass(frozen=True)
class NoParameters:
    """``Parameters`` of a method without settings."""


class MethodEntry:
    """The parameters of a registered method, tracker or controller."""

    name: str
    overrides: Mapping[str, Any]

    @property
    def parameters_class(self) -> type:
        """The dataclass of the method's parameters."""
        raise NotImplementedError

    def written(self) -> dict[str, Any]:
        """Return the values of all tunable parameters as the method was written, without tuning."""
        return {name: field.default for name, field in self.tunables().items()} | dict(self.overrides)

    def tunables(self) -> dict[str, dataclasses.Field[Any]]:
        """Return the parameters that declare bounds for tuning (``tunable``), by name."""
        return {field.name: field for field in dataclasses.fields(self.parameters_class) if "low" in field.metadata}

    def _with(self, values: Mapping[str, Any]) -> Any:
        """Return the parameters with ``values`` set; ValueError for an unknown name, or text in place of a number."""
        known = {field.name: field for field in dataclasses.fields(self.parameters_class)}
        for name, value in values.items():
            if name not in known:
                wanted = f"parameters among {', '.join(sorted(known))}" if known else "no parameter"
                raise ValueError(f"{self.name}: expected {wanted}, got {name!r}{nearest(name, known)}")
            if isinstance(value, str) and isinstance(known[name].default, int | float):
                raise ValueError(f"{self.name}: expected a number for {name}, got {value!r}")
        return self.parameters_class(**values)


@dataclass(frozen=True)
class TrackerEntry(MethodEntry):
    """One registered tracker.

    Attributes:
        name: the name that users type.
        role: its role in a comparison; exactly one tracker of a suite is ``ours``.
        summary: one line.
        tracker: class with ``Parameters`` and ``__init__(parameters, rng)``, a ``Tracker`` or a ``MultiTracker``.
        overrides: parameter values that make this entry a variant of ``tracker``.
        tuned_as: name under which its tuned values are stored.
        tuned: whether they replace the defaults.
        reproducible: False for a method that draws random numbers without a seed.
        suites: names of its suites; () = the default one.
        edition: of its answers; raise it when they change.
        missing: returns what it needs that is not installed, and how to install it, "" if nothing; with something
            missing the tracker is left out of default runs.
    """

    name: str
    role: Role
    summary: str
    tracker: Callable[[Any, np.random.Generator], Any]
    overrides: dict[str, Any]
    tuned_as: str
    tuned: bool
    reproducible: bool
    suites: tuple[str, ...]
    missing: Callable[[], str]
    edition: int

    def parameters(self, **changes: Any) -> Any:
        """Return the parameters: defaults, then tuned values if they replace them, then overrides, then ``changes``."""
        tuned = tuned_values(self.tuned_as, self.tracker.__module__) if self.tuned else {}
        return self._with({**tuned, **self.overrides, **changes})

    @property
    def parameters_class(self) -> type:
        """See ``MethodEntry``."""
        return self.tracker.Parameters  # type: ignore[attr-defined, no-any-return]

    @property
    def follows_many(self) -> bool:
        """Whether the tracker is a ``MultiTracker``."""
        return hasattr(self.tracker, "start")

    def create(self, rng: np.random.Generator, **changes: Any) -> Any:
        """Return a new tracker that draws from ``rng``: a ``Tracker`` or a ``MultiTracker``."""
        return self.tracker(self.parameters(**changes), rng)

    def create_for_one(
        self, rng: np.random.Generator, background: Sequence[Observation] = (), site: SiteSurvey | None = None
    ) -> Tracker:
        """Return a new tracker of one target; a ``MultiTracker`` is reduced to one of its tracks."""
        tracker = self.create(rng)
        return FollowOne(tracker, background, site) if self.follows_many else tracker


def tunable(default: float, low: float, high: float, *, log: bool = False) -> Any:
    """Declare a parameter that tuning may set within [low, high], both included; whole numbers stay whole.

    Raises:
        ValueError: if ``default`` lies outside, if there is nothing between the bounds, or for ``log`` down to 0.
    """
    good = low < high and low <= default <= high
    if not good or (log and low <= 0):
        wanted = f"low < high with the default between them{', all above 0 with log' if log else ''}"
        raise ValueError(f"tunable: expected {wanted}, got default {default}, low {low} and high {high}")
    return dataclasses.field(default=default, metadata={"low": low, "high": high, "log": log})


def _misses_nothing() -> str:
    return ""


def register(
    name: str,
    *,
    role: Role,
    summary: str,
    reproducible: bool = True,
    suites: tuple[str, ...] = (),
    missing: Callable[[], str] = _misses_nothing,
    edition: int = 1,
) -> Callable[[_T], _T]:
    """Class decorator: register a tracker under ``name`` for ``suites``; () = the default one.

    The other arguments are attributes of ``TrackerEntry``.

    Raises:
        ValueError: for a name that is taken, an unknown role, or a class without parameters or methods.
    """

    def add(tracker: _T) -> _T:
        begins = [name for name in ("start", "initialise") if hasattr(tracker, name)]
        check_registered(tracker, role, get_args(Role), *begins[:1], "update")
        if not begins:
            wanted = f"initialise, or start if it follows many targets, in class {tracker.__name__}"
            raise ValueError(f"tracker: expected a method {wanted}, got neither")
        as_written = role == "as-written" or "kept_as_written" in _tuning(name, tracker.__module__)
        new = TrackerEntry(
            name=name,
            role=role,
            summary=summary,
            tracker=tracker,
            overrides={},
            tuned_as=name,
            tuned=not as_written,
            reproducible=reproducible,
            suites=suites,
            missing=missing,
            edition=edition,
        )
        _add(new)
        if as_written and tuned_values(name, tracker.__module__):
            _add(dataclasses.replace(new, name=f"{name}_tuned", role="tuned", summary=f"{summary}, tuned", tuned=True))
        return tracker

    return add


def check_registered(registered: type, role: str, roles: tuple[str, ...], *methods: str) -> None:
    """Raise ValueError for a role not in ``roles``, or a class without ``methods`` or a dataclass ``Parameters``."""
    if role not in roles:
        raise ValueError(f"role: expected one of {', '.join(roles)}; got {role!r}")
    if not dataclasses.is_dataclass(getattr(registered, "Parameters", None)):
        raise ValueError(f"Parameters: expected a dataclass of this name in class {registered.__name__}, got none")
    for method in methods:
        if not callable(getattr(registered, method, None)):
            raise ValueError(f"{method}: expected a method of this name in class {registered.__name__}, got none")


def register_variant(name: str, of: str, *, summary: str, **overrides: Any) -> None:
    """Register an ablation of a tracker: the same code, tuned values and suites, with ``overrides``.

    Raises:
        ValueError: for a name that is taken, or an unknown tracker ``of``.
    """
    _add(dataclasses.replace(entry(of), name=name, role="variant", summary=summary, overrides=overrides))


def entries() -> dict[str, TrackerEntry]:
    """Return all trackers by name: those of our classes in the order of ``_MODULES``, then others as registered."""
    order = {module: place for place, module in enumerate(_MODULES)}
    for module in _MODULES:
        importlib.import_module(module)
    return dict(sorted(_ENTRIES.items(), key=lambda item: order.get(item[1].tracker.__module__, len(order))))


def entry_or_none(name: str) -> TrackerEntry | None:
    """Return one tracker's entry, None for an unknown name; of ours, only the module that defines it is imported."""
    _load(name)
    return _ENTRIES.get(name)


def entry(name: str) -> TrackerEntry:
    """See ``entry_or_none``. Raises ValueError for an unknown name; lists the known ones."""
    found = entry_or_none(name)
    if found is None:
        known = entries()
        near = nearest(name, known) + OWN_NEEDS_MODULE
        raise ValueError(f"tracker: expected one of {', '.join(known)}; got {name!r}{near}")
    return found


def _home(name: str) -> str:
    """Return the module that registers a tracker of ours, or one whose name begins with that; else ""."""
    begun = (each for each in _HOMES if name == each or name.startswith(f"{each}_"))
    return _HOMES.get(max(begun, key=len, default=""), "")


def _load(name: str) -> None:
    """Import the ``_home`` of a name, if it has one."""
    if module := _home(name):
        importlib.import_module(module)


def nearest(name: str, known: Iterable[str]) -> str:
    """Return the known name that ``name`` begins, or the nearest one, as a question in parentheses; else nothing.

    The simulator, which trackers may not import, has ``sim.checks.suggestion`` for its own names.
    """
    names = list(known)
    # Of editions of one thing the latest, which is listed last.
    begun = sorted((each for each in reversed(names) if name and each.startswith(name)), key=len)
    near = begun[:1] or difflib.get_close_matches(name, names, 1)
    return f" (did you mean {near[0]}?)" if near else ""


def tuned_file(name: str, module: str) -> Path:
    """Return the file with the values that tuning found for a method.

    It is ``tuned/NAME.json``, in this package or beside the ``module`` of a user that defines the method.
    """
    own = getattr(sys.modules.get(module), "__file__", None)
    folder = Path(__file__).parent if own is None or module.startswith(f"{__package__}.") else Path(own).parent
    return folder / "tuned" / f"{name}.json"


def tuned_values(name: str, module: str) -> dict[str, Any]:
    """Return the values in ``tuned_file``; empty if there is none."""
    values: dict[str, Any] = _tuning(name, module)["parameters"]
    return values


def _tuning(name: str, module: str) -> dict[str, Any]:
    """Return the content of ``tuned_file``; no values if there is none. Raises ValueError for another content."""
    file = tuned_file(name, module)
    if not file.is_file():
        return {"parameters": {}}
    try:
        found: dict[str, Any] = json.loads(file.read_text())
        dict(found["parameters"])
    except (ValueError, KeyError, TypeError) as error:
        raise ValueError(f'{file}: expected JSON such as {{"parameters": {{"NAME": 1.0}}}}, got {error!r}') from None
    return found


def _add(new: TrackerEntry) -> None:
    # Ours come first: a user's tracker that takes the name of one of ours is refused, not ours at its import.
    _load(new.name)
    if new != _ENTRIES.get(new.name, new):
        raise ValueError(f"name: expected one that no tracker has, got {new.name!r}")
    _ENTRIES[new.name] = new
