"""Presets of ``harbour``."""

from __future__ import annotations

from dataclasses import dataclass

from sim.checks import check, check_types, check_within

Range = tuple[float, float]


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
        car_stays_s: how long a car stands that comes; it stays to the end if that is sooner, or if nobody is left to
            fetch it. boat_stays_s: how long a boat lies at the berth, if it does not pass.
        start_h: solar time of the first picture. day_of_year: 1 to 366.
        cloud: share of the sky that is covered. wind_mps, rain_mm_h: of the day. swell_m: its significant height.
        background: pictures without intruders before the first frame, evenly over three days.
        cloud_before, wind_before_mps, swell_before_m: of those days.
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

    def __post_init__(self) -> None:
        check_types(self)
        check_within(self, "frame_count", 2)
        check_within(self, "rate_hz", 0, above=True)
        check_within(self, "width_px height_px", 32, 4096)
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
        check_within(self, "start_h", 0, 24)
        check_within(self, "day_of_year", 1, 366)
        check_within(self, "cloud cloud_before", 0, 1)
        check_within(self, "wind_mps wind_before_mps", 0, 20)
        check_within(self, "car_stays_s boat_stays_s", 60)
        check_within(self, "rain_mm_h", 0, 20)
        check_within(self, "swell_m swell_before_m", 0, 1)
        check_within(self, "background", 0, 2000)


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
        cloud_before=(0.85, 1.0),
        wind_before_mps=(0.5, 2.5),
        swell_before_m=(0.02, 0.06),
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
        # takes who is there on the first picture for a part of it.
        background=200,
    ),
}
