"""The robot: one that waits, one for asyncio."""

from __future__ import annotations

import asyncio
import atexit
import functools
import itertools
import logging
import queue
import threading
import time
from collections.abc import AsyncIterator, Callable, Coroutine, Iterator, Sequence
from os import PathLike
from types import TracebackType
from typing import TYPE_CHECKING, Any, Literal, Optional, Protocol, TypeVar, Union, cast

from ._events import ContactPlace, Event, NoPlace, Refused, WhiskerFacts, event_of, line_of, place_of, whiskers_of
from ._link import PATIENCE_S, AgentEnded, Link
from ._states import States

#: Events that wait for the program; beyond that the oldest ones are dropped. The agent repeats pressures.
EVENTS_MAX = 1000
_LOG = logging.getLogger("vibrissa_robot")

E = TypeVar("E", bound=Event)


class Array(Protocol):
    """An array of numbers, as of numpy or of the module `array`."""

    def tolist(self) -> Any: ...


Samples = Union[float, Sequence[float], Array]
Config = Union[str, PathLike[str]]
Gauge = Literal["OK", "SATURATED", "OPEN", "SHORT"]
Regulator = Literal["OK", "FILLING", "VENTING", "SUPPLY_LOW", "LEAK", "FAULT"]


class Robot:
    """A robot whose agent runs in this process and keeps the contract with the supervisor.

    Report each whisker's pressure at least once a second, and each contact. Take events by iterating over the robot,
    by `next_event`, or by callbacks (`on`). Methods may be called from any thread.

    Args:
        config: Path of `agent.toml`. Its `[driver]` needs no way to a driver: this object is the driver.
        log: Filter of the agent's log on standard error, such as `info`; the first robot of a process decides.
    """

    def __init__(self, config: Config = "agent.toml", *, log: str = "warn") -> None:
        #: Events, each with whether a callback has taken it.
        self._events: queue.Queue[tuple[Event, bool]] = queue.Queue(EVENTS_MAX)
        self._callbacks: list[tuple[type[Any], Callable[[Any], object]]] = []
        self._whiskers: list[WhiskerFacts] = []
        self._has_whiskers = threading.Event()
        self._questions = itertools.count()
        self._answers: dict[str, queue.Queue[Union[ContactPlace, NoPlace]]] = {}
        #: Events that were dropped because nobody took them: neither the program nor a callback.
        self.dropped = 0
        self._states = States()
        self._link = Link(config, log, self._receive, self._states.lines)
        atexit.register(self.close)

    def __enter__(self) -> Robot:
        return self

    def __exit__(
        self, kind: Optional[type[BaseException]], raised: Optional[BaseException], trace: Optional[TracebackType]
    ) -> None:
        self.close()

    def close(self) -> None:
        """Stops the agent: it says farewell to the supervisor, and stores contacts that have no receipt yet."""
        atexit.unregister(self.close)
        self._link.close()

    @property
    def whiskers(self) -> list[WhiskerFacts]:
        """The whiskers of the configuration, with the pressures that they had when the agent started.

        Raises:
            AgentEnded: The agent could not start.
        """
        until = time.monotonic() + PATIENCE_S
        while not self._has_whiskers.wait(0.05):
            self._check()
            if time.monotonic() >= until:
                raise TimeoutError("the agent does not answer")
        return list(self._whiskers)

    def contact(
        self,
        whisker: int,
        *,
        deflection_mm: float,
        strain: float,
        distance_mm: Optional[float] = None,
        distance_sd_mm: Optional[float] = None,
        ratio: Optional[float] = None,
        ratio_sd: Optional[float] = None,
        tip: Optional[bool] = None,
        saturated: Optional[bool] = None,
        pressure_mpa: Optional[float] = None,
        temperature_c: Optional[float] = None,
        test_id: Optional[str] = None,
        array: Optional[str] = None,
        t_us: Optional[int] = None,
    ) -> None:
        """Reports a contact: its deflection, the strain, and where it was, by distance, by contact ratio, or at the tip.

        Args:
            whisker: Number of the whisker in its array.
            deflection_mm: Deflection at the contact.
            strain: Strain of the gauge without its value at rest, m/m.
            distance_mm: Distance from the base, with its standard deviation `distance_sd_mm`.
            ratio: Contact ratio (0: base, 1: tip), with its standard deviation `ratio_sd`.
            tip: True for a contact at the tip.
            saturated: True if the strain was at an end of the range of gauge or converter, and may have been larger. Nothing
                is learned from such a contact.
            pressure_mpa: Pressure at the contact; otherwise the newest one of `pressure`.
            temperature_c: Temperature at the contact; otherwise the newest one of `pressure`.
            test_id: Touch test to which the contact belongs.
            array: Array; may be left out if the robot has one.
            t_us: Time in microseconds since 1970 UTC; otherwise now.
        """
        self._send("contact", _without_self(locals()))

    def missed(
        self,
        whisker: int,
        *,
        distance_mm: float,
        distance_sd_mm: Optional[float] = None,
        test_id: Optional[str] = None,
        array: Optional[str] = None,
        t_us: Optional[int] = None,
    ) -> None:
        """Reports a touch that was due at this distance and did not come."""
        self._send("contact", {**_without_self(locals()), "touched": False})

    def strain(
        self,
        whisker: int,
        strain: Samples,
        *,
        strain_2: Optional[Samples] = None,
        every_us: Optional[int] = None,
        deflection_mm: Optional[Samples] = None,
        distance_mm: Optional[Samples] = None,
        test_id: Optional[str] = None,
        array: Optional[str] = None,
        t_us: Optional[int] = None,
    ) -> None:
        """Reports samples of a gauge, of which the agent makes contacts; `every_us` is the spacing of a list."""
        self._send("strain", _without_self(locals()))

    def motion(
        self,
        whisker: int,
        *,
        deflection_mm: Optional[Samples] = None,
        distance_mm: Optional[Samples] = None,
        ratio: Optional[Samples] = None,
        every_us: Optional[int] = None,
        test_id: Optional[str] = None,
        array: Optional[str] = None,
        t_us: Optional[int] = None,
    ) -> None:
        """Reports where the base of a whisker is and what it touches, apart from the strain: the agent joins both by time."""
        self._send("motion", _without_self(locals()))

    def driving(self, driving: bool) -> None:
        """Reports that the robot moves from now on, or stands again: the agent then expects shaking."""
        self._send("driving", _without_self(locals()))

    def task(self, task: bool) -> None:
        """Reports that the robot is in a task from now on, or not any more: meanwhile it gets no setpoints and tests."""
        self._send("task", _without_self(locals()))

    def pressure(
        self,
        whisker: int,
        pressure_mpa: float,
        *,
        regulator: Optional[Regulator] = None,
        temperature_c: Optional[float] = None,
        supply_mpa: Optional[float] = None,
        array: Optional[str] = None,
        t_us: Optional[int] = None,
    ) -> None:
        """Reports the pressure of a chamber, MPa above the atmosphere: at least once a second."""
        self._send("pressure", _without_self(locals()))

    def fault(
        self,
        whisker: int,
        *,
        gauge: Optional[Gauge] = None,
        regulator: Optional[Regulator] = None,
        array: Optional[str] = None,
    ) -> None:
        """Reports a change of the condition of a gauge or a regulator."""
        self._send("fault", _without_self(locals()))

    def test_state(self, test_id: str, state: Literal["RUNNING", "DONE", "FAILED"]) -> None:
        """Reports the progress of a touch test."""
        self._send("test_state", _without_self(locals()))

    def locate(
        self, whisker: int, *, strain: float, deflection_mm: float, array: Optional[str] = None
    ) -> ContactPlace:
        """Where a touch was, from its strain (without its value at rest) and deflection.

        Uses the whisker's response as the supervisor has learned it, at the present pressure.

        Raises:
            NoPlace: No place on the whisker explains the strain, or the response is not known; the text says why.
            TimeoutError: The agent does not answer. Not from a callback (`on`): the answer waits for its end.
        """
        question = str(next(self._questions))
        answer: queue.Queue[Union[ContactPlace, NoPlace]] = queue.Queue(1)
        self._answers[question] = answer
        try:
            fields = {"id": question, "whisker": whisker, "strain": strain, "deflection_mm": deflection_mm}
            self._send("locate", {**fields, "array": array})
            place = answer.get(timeout=PATIENCE_S)
        except queue.Empty:
            self._check()
            raise TimeoutError("the agent does not answer") from None
        finally:
            del self._answers[question]
        if isinstance(place, NoPlace):
            raise place
        return place

    def on(self, kind: type[E]) -> Callable[[Callable[[E], object]], Callable[[E], object]]:
        """Has a function called with each event of a kind, in a thread of the robot: `@robot.on(SetPressure)`.

        It must return soon, because the next event waits for it. An exception in it is logged.
        """

        def register(function: Callable[[E], object]) -> Callable[[E], object]:
            self._callbacks.append((kind, cast(Callable[[Any], object], function)))
            return function

        return register

    def next_event(self, timeout_s: Optional[float] = None) -> Optional[Event]:
        """The next event; None if there is none in time.

        Raises:
            AgentEnded: The agent has ended, and all its events are taken.
        """
        until = None if timeout_s is None else time.monotonic() + timeout_s
        while True:
            wait_s = 0.1 if until is None else min(0.1, until - time.monotonic())
            try:
                return (self._events.get(timeout=wait_s) if wait_s > 0 else self._events.get_nowait())[0]
            except queue.Empty:
                self._check()
                if until is not None and time.monotonic() >= until:
                    return None

    def __iter__(self) -> Iterator[Event]:
        """Events until the robot is closed."""
        while True:
            try:
                event = self.next_event()
            except AgentEnded:
                if self._link.is_closed:
                    return
                raise
            if event is not None:
                yield event

    def _check(self) -> None:
        ended = self._link.ended()
        if ended is not None:
            raise ended

    def _send(self, kind: str, fields: dict[str, Any]) -> None:
        line = line_of(kind, fields)
        self._states.take(kind, fields)
        self._link.send(line)

    def _receive(self, line: dict[str, Any]) -> None:
        """Takes a line of the agent, in the thread of the link."""
        if line.get("type") == "hello":
            self._whiskers = whiskers_of(line)
            self._has_whiskers.set()
            return
        if line.get("type") == "place":
            answer = self._answers.get(line.get("id", ""))
            if answer is not None:
                answer.put(place_of(line))
            return
        event = event_of(line)
        if event is None:
            return
        if isinstance(event, Refused):
            _LOG.warning("the agent refused a line: %s: %s", event.problem, event.remedy)
        callbacks = [(kind, function) for kind, function in list(self._callbacks) if isinstance(event, kind)]
        while True:
            try:
                self._events.put_nowait((event, bool(callbacks)))
                break
            except queue.Full:
                try:
                    _, is_taken = self._events.get_nowait()
                    self.dropped += not is_taken
                except queue.Empty:
                    pass
        for kind, function in callbacks:
            try:
                function(event)
            except BaseException:
                # `sys.exit()` ends no program from this thread, and would end the thread without a word.
                _LOG.exception("a callback for %s failed", kind.__name__)


def _without_self(fields: dict[str, Any]) -> dict[str, Any]:
    return {name: value for name, value in fields.items() if name != "self"}


if TYPE_CHECKING:
    from typing_extensions import Concatenate, ParamSpec

    P = ParamSpec("P")
    R = TypeVar("R")


def _awaited(
    method: Callable[Concatenate[Robot, P], R],
) -> Callable[Concatenate[AsyncRobot, P], Coroutine[Any, Any, R]]:
    """A method of `Robot` for asyncio: it may wait for the agent, so it runs in a thread."""

    @functools.wraps(method)
    async def call(robot: AsyncRobot, /, *args: P.args, **kwargs: P.kwargs) -> R:
        return await asyncio.to_thread(method, robot.robot, *args, **kwargs)

    return call


class AsyncRobot:
    """The same for asyncio: `async with AsyncRobot("agent.toml") as robot`, `await robot.pressure(...)`,
    `async for event in robot`. Arguments of each method are those of `Robot`.
    """

    def __init__(self, config: Config = "agent.toml", *, log: str = "warn") -> None:
        self._config, self._log = config, log
        self._robot: Optional[Robot] = None

    async def __aenter__(self) -> AsyncRobot:
        self._robot = await asyncio.to_thread(lambda: Robot(self._config, log=self._log))
        return self

    async def __aexit__(
        self, kind: Optional[type[BaseException]], raised: Optional[BaseException], trace: Optional[TracebackType]
    ) -> None:
        await self.close()

    @property
    def robot(self) -> Robot:
        """The robot behind this one, for callbacks.

        Raises:
            AgentEnded: Before `async with`.
        """
        if self._robot is None:
            raise AgentEnded("use it with `async with`")
        return self._robot

    async def close(self) -> None:
        """Stops the agent."""
        await asyncio.to_thread(self.robot.close)

    async def whiskers(self) -> list[WhiskerFacts]:
        """The whiskers of the configuration."""
        return await asyncio.to_thread(lambda: self.robot.whiskers)

    contact = _awaited(Robot.contact)
    missed = _awaited(Robot.missed)
    strain = _awaited(Robot.strain)
    motion = _awaited(Robot.motion)
    driving = _awaited(Robot.driving)
    task = _awaited(Robot.task)
    pressure = _awaited(Robot.pressure)
    fault = _awaited(Robot.fault)
    test_state = _awaited(Robot.test_state)
    locate = _awaited(Robot.locate)

    async def next_event(self, timeout_s: Optional[float] = None) -> Optional[Event]:
        """The next event; None if there is none in time."""
        until = None if timeout_s is None else time.monotonic() + timeout_s
        while True:
            # In short waits: a cancelled task must not leave a thread behind that takes an event.
            event = self.robot.next_event(0.0)
            if event is not None or (until is not None and time.monotonic() >= until):
                return event
            await asyncio.sleep(0.01)

    async def __aiter__(self) -> AsyncIterator[Event]:
        """Events until the robot is closed."""
        while True:
            try:
                event = await self.next_event()
            except AgentEnded:
                if self.robot._link.is_closed:
                    return
                raise
            if event is not None:
                yield event
