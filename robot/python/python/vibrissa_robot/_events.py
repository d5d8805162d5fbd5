"""What the agent tells a robot, as typed events."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal, Optional, Union


@dataclass(frozen=True)
class WhiskerFacts:
    """A whisker of the robot."""

    array: str
    whisker: int
    #: Pressure to hold now, MPa above the atmosphere.
    pressure_mpa: float
    pressure_max_mpa: float


@dataclass(frozen=True)
class SetPressure:
    """Hold this pressure. It is repeated every 2 s: vent if none comes for some seconds."""

    array: str
    whisker: int
    #: MPa above the atmosphere.
    pressure_mpa: float
    #: Highest rate of change.
    slew_mpa_per_s: float


@dataclass(frozen=True)
class ReadingGain:
    """Multiply each reading of the whisker by this factor from now on, at every contact ratio.

    Only with `applies_gain` in the configuration. Contacts keep the strain as measured. It is repeated every 2 s.
    """

    array: str
    whisker: int
    reading_gain: float


@dataclass(frozen=True)
class Test:
    """Do a touch test: report its progress by `test_state`, and its contacts with its `test_id`."""

    test_id: str
    array: str
    whisker: int
    kind: Literal["WALL", "TIP"]
    distances_mm: Sequence[float]
    deflections_mm: Sequence[float]
    #: Number of touches.
    contacts: int


@dataclass(frozen=True)
class Estimate:
    """What the supervisor knows of a whisker."""

    array: str
    whisker: int
    length_mm: float
    #: 95 % interval of the length.
    length_low_mm: float
    length_high_mm: float
    #: Such as HEALTHY or TRIMMED.
    condition: str
    #: Pairs of contact ratio and factor on the strain.
    gain: Sequence[tuple[float, float]]


@dataclass(frozen=True)
class ContactPlace:
    """The place of a touch on a whisker."""

    #: Most likely distance from the base, without the chamber's elongation.
    distance_mm: float
    #: 95 % interval of the distance; it ends at the chamber and at the tip.
    distance_low_mm: float
    distance_high_mm: float


class NoPlace(Exception):
    """No place of the touch is known; the text says why."""


@dataclass(frozen=True)
class Refused:
    """The agent refused something that the program has sent."""

    problem: str
    remedy: str


Event = Union[SetPressure, ReadingGain, Test, Estimate, Refused]


def whiskers_of(line: Mapping[str, Any]) -> list[WhiskerFacts]:
    """The whiskers in the agent's `hello`."""
    return [
        WhiskerFacts(one["array"], one["whisker"], one["pressure_mpa"], one["pressure_max_mpa"])
        for one in line["whiskers"]
    ]


def event_of(line: Mapping[str, Any]) -> Optional[Event]:
    """The event of a line; None for a word of a later version."""
    kind = line.get("type")
    if kind == "set_pressure":
        return SetPressure(line["array"], line["whisker"], line["pressure_mpa"], line["slew_mpa_per_s"])
    if kind == "reading_gain":
        return ReadingGain(line["array"], line["whisker"], line["reading_gain"])
    if kind == "test":
        return Test(
            line["test_id"],
            line["array"],
            line["whisker"],
            line["kind"],
            tuple(line["distances_mm"]),
            tuple(line["deflections_mm"]),
            line["contacts"],
        )
    if kind == "estimate":
        return Estimate(
            line["array"],
            line["whisker"],
            line["length_mm"],
            line["length_low_mm"],
            line["length_high_mm"],
            line["condition"],
            tuple((ratio, factor) for ratio, factor in line["gain"]),
        )
    if kind == "error":
        return Refused(line["problem"], line["do"])
    return None


def place_of(line: Mapping[str, Any]) -> Union[ContactPlace, NoPlace]:
    """The place in the agent's answer to `locate`, or why there is none."""
    if "problem" in line:
        return NoPlace(line["problem"])
    return ContactPlace(line["distance_mm"], line["distance_low_mm"], line["distance_high_mm"])


def line_of(kind: str, fields: Mapping[str, object]) -> bytes:
    """A line for the agent; a field of None is left out.

    Raises:
        TypeError: A value is neither a number nor an array of numbers.
        ValueError: A number is not finite.
    """
    known = {name: value for name, value in fields.items() if value is not None}
    return json.dumps({"type": kind, **known}, allow_nan=False, default=_plain).encode() + b"\n"


def _plain(value: object) -> object:
    """Plain numbers of a number or an array of a library, such as numpy's `float32`; or the list of a sequence."""
    tolist = getattr(value, "tolist", None)
    if callable(tolist):
        return tolist()
    if isinstance(value, Sequence) and not isinstance(value, (bytes, bytearray)):
        return list(value)
    raise TypeError(f"{value!r} is neither a number nor an array of numbers")
