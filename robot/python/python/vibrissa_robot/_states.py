"""States that a robot reports once, and that count until it reports others."""

from __future__ import annotations

import threading
from collections.abc import Mapping
from typing import Any, Optional

from ._events import line_of

Place = tuple[Optional[str], int]


class States:
    """The newest states: whether the robot drives or is in a task, and bad gauges and regulators."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._robot: dict[str, bool] = {}
        self._whiskers: dict[Place, dict[str, str]] = {}

    def take(self, kind: str, fields: Mapping[str, Any]) -> None:
        """Remembers the states of a line to the agent."""
        with self._lock:
            if kind in ("driving", "task"):
                self._robot[kind] = fields[kind]
            elif kind == "fault":
                told = {part: fields[part] for part in ("gauge", "regulator") if fields[part] is not None}
                self._whiskers.setdefault((fields["array"], fields["whisker"]), {}).update(told)
            elif kind == "pressure" and fields["regulator"] is not None:
                # Each reading repeats it.
                self._whiskers.get((fields["array"], fields["whisker"]), {}).pop("regulator", None)

    def lines(self) -> bytes:
        """The lines that tell them to an agent that knows none."""
        with self._lock:
            lines = [line_of(kind, {kind: value}) for kind, value in self._robot.items()]
            for (array, whisker), states in self._whiskers.items():
                if states:
                    lines.append(line_of("fault", {"array": array, "whisker": whisker, **states}))
        return b"".join(lines)
