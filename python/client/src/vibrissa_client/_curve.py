"""Response curves: the sensitivity of a whisker along its length."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal, Optional

from . import models

if TYPE_CHECKING:
    from matplotlib.axes import Axes

#: Marker or line of a curve in the plot.
_Style = Literal["-", "--", "o"]


@dataclass(frozen=True)
class Curve:
    """Sensitivities by contact ratio (0 at the base, 1 at the tip), in strain per mm of deflection."""

    #: Place of the whisker: fleet/robot/array/number.
    name: str
    ratio: Sequence[float]
    #: A value for each ratio by the name of the line; None where a contact would lie on the chamber, or none was measured.
    per_mm: dict[str, Sequence[Optional[float]]]
    styles: dict[str, _Style]

    def plot(self, axes: Optional[Axes] = None) -> Axes:
        """Draws the curve with matplotlib (`pip install vibrissa-client[plot]`)."""
        if axes is None:
            from matplotlib import pyplot

            _, axes = pyplot.subplots()
        for name, values in self.per_mm.items():
            numbers = [float("nan") if value is None else 1e3 * value for value in values]
            axes.plot(self.ratio, numbers, self.styles[name], label=name)
        axes.set_xlabel("contact ratio (0: base, 1: tip)")
        axes.set_ylabel("sensitivity, 0.001 strain / mm")
        axes.set_title(self.name)
        axes.grid(alpha=0.3)
        axes.legend()
        return axes


def place(whisker: models.Whisker) -> tuple[str, str, str, int]:
    """The four parts that name a whisker."""
    return whisker["fleet"], whisker["robot"], whisker["array"], whisker["whisker"]


def named(parts: tuple[str, str, str, int]) -> str:
    """The place of a whisker as one word."""
    return "/".join(map(str, parts))


def response(parts: tuple[str, str, str, int], model: models.ModelOfWhisker) -> Curve:
    """The curve of a whisker as it is."""
    rows = model["by_ratio"]
    whole = f"whole: {model['whole_length_mm']:.0f} mm, {model['nominal_pressure_mpa']:.3f} MPa"
    now = f"now: {model['length_mm']:.1f} mm, {model['pressure_mpa']:.3f} MPa"
    return Curve(
        named(parts),
        [row["ratio"] for row in rows],
        {
            whole: [row.get("whole_per_mm") for row in rows],
            now: [row.get("own_per_mm") for row in rows],
            "measured": [row.get("measured_per_mm") for row in rows],
        },
        {whole: "--", now: "-", "measured": "o"},
    )


def after_cut(parts: tuple[str, str, str, int], length_mm: float, answer: models.WhatIfAnswer) -> Curve:
    """The curve of a whisker as it would be after a cut."""
    rows = answer["by_ratio"]
    cut, compensated = f"cut to {length_mm:.1f} mm", "compensated"
    return Curve(
        named(parts),
        [row["ratio"] for row in rows],
        {
            "whole": [row.get("before_per_mm") for row in rows],
            cut: [row.get("after_per_mm") for row in rows],
            compensated: [row.get("compensated_per_mm") for row in rows],
        },
        {"whole": "--", cut: "-", compensated: "-"},
    )
