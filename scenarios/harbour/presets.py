"""Presets of ``harbour``."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

from scenarios.scenario import check_length, check_size
from sim.checks import check, check_types, check_within

Range = tuple[float, float]
BY_SEED = "by seed"
_LONGEST_S = 12 * 3600.0


@dataclass(frozen=True, slots=True)
class DayBefore:
    """One of the days before the episode's own; pairs are ranges of a uniform draw.

    Attributes:
        days_ago: how many days before the episode's own, so that the tide is another one.
        cloud: share of the sky that is covered. wind_mps, rain_mm_h: of the day. swell_m: its significant height.
    """

    days_ago: int
    cloud: Range
    wind_mps: Range
    rain_mm_h: Range
    swell_m: Range

    def __post_init__(self) -> None:
        check_types(self)
        check_within(self, "days_ago", 1, 60)
        check_within(self, "cloud", 0, 1)
        check_within(self, "wind_mps rain_mm_h", 0, 20)
        check_within(self, "swell_m", 0, 1)


@dataclass(frozen=True, slots=True)
class Harbour:
    """Configuration of an episode; pairs are ranges of a uniform draw.

    Attributes:
        summary: one line.
        frame_count: number of frames. rate_hz: frames per second.
        width_px, height_px: of each picture; it always shows the whole site.
        closed_loop: True if commands steer a second camera, False if there is none.
        people, cars, boats: how many come in all; who gets out of a car counts as another person than who got in.
        patrols: how many of the people walk about from the first picture to the last, for a camera that follows.
        buoys: moored boats that swing about buoys.
        deliveries: how many of the cars that come stop on the apron, across the line of sight; others take a bay.
        cars_before: how many of the cars have stood since before the first picture.
        cars_without_contrast: how many of these have stood so long that they are as warm as the level ground about
            them; they stay to the end.
        car_stays_s: how long a car stands that comes; it stays to the end if that is sooner, or if no person is left to
            fetch it. boat_stays_s: how long a boat lies at the berth, if it does not pass.
        start_h: solar time of the first picture. day_of_year: 1 to 366.
        cloud: share of the sky that is covered. wind_mps, rain_mm_h: of the day. swell_m: its significant height.
        background: pictures without intruders before the first frame, evenly over three days.
        cloud_before, wind_before_mps, swell_before_m: of those days, which are dry and the three before the episode's.
        days_before: these days one by one in place of that, the earliest first; () for none.
        swell_period_s: of the swell's waves, on which boats then float as they pass under them; None: these are 14 to
            30 m long, and boats move by chance as much as such waves move them.
        site: ``fixed``, the one harbour of the standing presets; ``by seed``, another one each day; or a number, which
            stands for one harbour.
        episodes_a_day: so many episodes with successive seeds are of one day, at the same hours: weather, tide, what is
            moored and parked, the camera and the days before are the same, and a data set has the pictures of these
            once. Who comes differs. A divisor of 10,000: no day is in both splits.
    """

    summary: str
    frame_count: int = 2100
    rate_hz: float = 0.5
    width_px: int = 384
    height_px: int = 288
    closed_loop: bool = False
    people: int = 15
    cars: int = 4
    boats: int = 2
    cars_before: int = 1
    cars_without_contrast: int = 0
    patrols: int = 0
    buoys: int = 2
    deliveries: int = 0
    car_stays_s: Range = (600.0, 6000.0)
    boat_stays_s: Range = (500.0, 1050.0)
    start_h: Range = (7.0, 19.0)
    day_of_year: tuple[int, int] = (60, 330)
    cloud: Range = (0.0, 1.0)
    wind_mps: Range = (0.5, 7.0)
    rain_mm_h: Range = (0.0, 0.0)
    swell_m: Range = (0.02, 0.15)
    background: int = 400
    cloud_before: Range = (0.0, 1.0)
    wind_before_mps: Range = (0.5, 7.0)
    swell_before_m: Range = (0.02, 0.2)
    days_before: tuple[DayBefore, ...] = ()
    episodes_a_day: int = 1
    swell_period_s: Range | None = None
    site: str | int = "fixed"

    def __post_init__(self) -> None:
        check_types(self)
        check_size(self)
        check_length(self, _LONGEST_S)
        check_within(self, "people", 1, 60)
        check_within(self, "cars", 0, 6)
        check_within(self, "boats", 0, 4)
        check_within(self, "cars_before", 0, 2)
        check_within(self, "patrols", 0, 3)
        check_within(self, "buoys", 0, 2)
        check("patrols", self.patrols <= self.people, f"at most people = {self.people}", self.patrols)
        others = self.cars - self.cars_before
        check_within(self, "deliveries", 0)
        check("deliveries", self.deliveries <= others, f"at most cars - cars_before = {others}", self.deliveries)
        check("cars_before", self.cars_before <= self.cars, f"at most cars = {self.cars}", self.cars_before)
        cold, before = self.cars_without_contrast, self.cars_before
        check("cars_without_contrast", 0 <= cold <= before, f"0 to cars_before = {before}", cold)
        ago = [each.days_ago for each in self.days_before]
        falling = all(first > second for first, second in pairwise(ago))
        check("days_before", len(ago) in (0, 3) and falling, "none or three days, the earliest first", ago)
        check_within(self, "start_h", 0, 24)
        check_within(self, "day_of_year", 1, 366)
        check_within(self, "cloud cloud_before", 0, 1)
        check_within(self, "wind_mps wind_before_mps", 0, 20)
        check_within(self, "car_stays_s boat_stays_s", 60, 7 * 86400)
        check_within(self, "rain_mm_h", 0, 20)
        check_within(self, "swell_m swell_before_m", 0, 1)
        check_within(self, "background", 0, 2000)
        if self.swell_period_s is not None:
            check_within(self, "swell_period_s", 2.5, 5.5)
        known = self.site in ("fixed", BY_SEED) if isinstance(self.site, str) else self.site >= 0
        check("site", known, f"'fixed', '{BY_SEED}' or a whole number >= 0", repr(self.site))
        alike = self.episodes_a_day
        check("episodes_a_day", alike >= 1 and 10_000 % max(alike, 1) == 0, "a divisor of 10,000", alike)


PRESETS = {
    "standard": Harbour("70 minutes by day, in any weather"),
    "hard": Harbour(
        "a night without contrast: swell, rain, wind",
        start_h=(20.5, 23.5),
        cloud=(0.9, 1.0),
        wind_mps=(4.0, 9.0),
        rain_mm_h=(1.0, 4.0),
        swell_m=(0.25, 0.45),
    ),
    "quick": Harbour(
        "two minutes with a few people, a car and a boat",
        frame_count=60,
        people=3,
        cars=1,
        boats=1,
        cars_before=0,
        patrols=1,
        background=40,
    ),
    "ten-minutes": Harbour(
        "ten minutes by day, in any weather: what parameters are tuned on", frame_count=300, people=8, cars=3, boats=1
    ),
    "paper-d": Harbour(
        "the paper's experiment: 70 minutes from six in the morning of a day in June",
        cars=3,
        boats=1,
        start_h=(6.0, 6.0),
        day_of_year=(152, 181),
        buoys=1,
        deliveries=2,
        car_stays_s=(120.0, 420.0),
        boat_stays_s=(60.0, 150.0),
        cloud=(0.85, 1.0),
        wind_mps=(0.5, 2.5),
        swell_m=(0.02, 0.06),
        cars_without_contrast=1,
        # "Three days with different sun, weather and tide". Of two days a week apart one has high water when the other
        # has low water.
        days_before=(
            DayBefore(16, cloud=(0.0, 0.2), wind_mps=(0.5, 2.5), rain_mm_h=(0.0, 0.0), swell_m=(0.02, 0.06)),
            DayBefore(9, cloud=(0.4, 0.7), wind_mps=(3.0, 6.0), rain_mm_h=(0.0, 0.0), swell_m=(0.05, 0.15)),
            DayBefore(1, cloud=(0.9, 1.0), wind_mps=(1.0, 4.0), rain_mm_h=(0.5, 3.0), swell_m=(0.05, 0.15)),
        ),
    ),
    "patrol": Harbour(
        "three minutes at five pictures a second: someone walks about, whom a second camera follows",
        frame_count=900,
        rate_hz=5.0,
        people=5,
        cars=2,
        boats=1,
        patrols=1,
        # An env takes these at each reset. With 100 the slow residual is so doubtful that a tracker of the background
        # learns the people of the first picture as a part of it.
        background=200,
    ),
}
SITES = {
    "sites": Harbour("70 minutes at any hour, at another harbour for each seed", site=BY_SEED, start_h=(0.0, 24.0)),
    # Swell from afar in light wind: what a wave reflects of a clear, cold sky changes by a kelvin or two from face to
    # back. Ripples of a stronger wind average that, and clouds are as warm as the water. Waves of 10 to 22 m are short
    # enough for several to be in the picture.
    "swell": Harbour(
        "another harbour for each seed, with swell on which boats heave, roll and pitch",
        site=BY_SEED,
        start_h=(0.0, 24.0),
        cloud=(0.0, 0.4),
        wind_mps=(0.5, 3.5),
        swell_m=(0.3, 0.6),
        swell_period_s=(2.6, 3.8),
    ),
    "rain": Harbour(
        "another harbour for each seed, in rain",
        site=BY_SEED,
        start_h=(0.0, 24.0),
        cloud=(0.8, 1.0),
        wind_mps=(2.0, 9.0),
        rain_mm_h=(2.0, 12.0),
    ),
}
"""At harbours by seed: the next version's. Trackers learnt nothing at any of them."""
PRESETS |= SITES
