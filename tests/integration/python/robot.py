"""A robot in Python with two simulated chambers: `robot.py sync|async AGENT_TOML`.

It ends when it has heard an estimate and has reached the pressure that an operator has set.
"""

import array
import asyncio
import inspect
import math
import sys
import time

from vibrissa_robot import AgentEnded, AsyncRobot, Estimate, Event, NoPlace, Refused, Robot, SetPressure

WANTED_MPA = 0.08
SECONDS_MAX = 60.0


class Chambers:
    """The pressures of two whiskers, and what was heard."""

    def __init__(self) -> None:
        self.pressure_mpa = [0.1, 0.1]
        self.targets: list[SetPressure] = []
        self.heard: list[Event] = []

    def hold(self, event: SetPressure) -> None:
        assert 0 <= event.pressure_mpa <= 0.2 and event.slew_mpa_per_s > 0, event
        self.targets.append(event)
        self.pressure_mpa[event.whisker] = event.pressure_mpa

    def is_done(self) -> bool:
        has_estimate = any(isinstance(event, Estimate) for event in self.heard)
        has_refusal = any(isinstance(event, Refused) for event in self.heard)
        return has_estimate and has_refusal and abs(self.pressure_mpa[1] - WANTED_MPA) < 1e-9


class Half:
    """A number of a library, such as numpy's `float32`, which is no `float`."""

    def __init__(self, value: float) -> None:
        self.value = value

    def tolist(self) -> float:
        return self.value


def numbers_of_libraries_are_taken(robot: Robot) -> None:
    robot.strain(0, array.array("f", [1e-5, 2e-5]), every_us=4000)
    robot.pressure(0, Half(0.1))  # type: ignore[arg-type]
    for wrong, refused in [(Half(math.nan), ValueError), (b"0.1", TypeError)]:
        try:
            robot.pressure(0, wrong)  # type: ignore[arg-type]
        except refused:
            continue
        raise AssertionError(f"{wrong!r} was accepted")


def strain(step: int) -> float:
    return 0.0123 + 1e-5 * (step % 7)


def with_threads(config: str) -> None:
    chambers = Chambers()
    with Robot(config) as robot:
        assert [whisker.whisker for whisker in robot.whiskers] == [0, 1]
        robot.on(SetPressure)(chambers.hold)
        try:
            robot.pressure(0, math.nan)
        except ValueError:
            pass
        else:
            raise AssertionError("NaN was accepted")
        numbers_of_libraries_are_taken(robot)
        robot.contact(7, deflection_mm=2.0, strain=0.01, distance_mm=50.0)
        until = time.monotonic() + SECONDS_MAX
        step = 0
        while not chambers.is_done() and time.monotonic() < until:
            step += 1
            for whisker in (0, 1):
                robot.pressure(whisker, chambers.pressure_mpa[whisker], temperature_c=24.0)
                robot.contact(whisker, deflection_mm=2.0, strain=strain(step), distance_mm=55.0)
            event = robot.next_event(0.05)
            if event is not None:
                chambers.heard.append(event)
        assert chambers.is_done(), chambers.heard[-5:]
        places_of_touches_are_told(robot)
        # Some seconds at the pressure, until the supervisor knows that it was reached.
        until = time.monotonic() + 2.0
        while time.monotonic() < until:
            for whisker in (0, 1):
                robot.pressure(whisker, chambers.pressure_mpa[whisker])
            time.sleep(0.1)
        the_agent_is_found_again(robot)
    assert robot.dropped == 0
    a_closed_robot_says_so(robot)


def places_of_touches_are_told(robot: Robot) -> None:
    place = robot.locate(0, strain=strain(0), deflection_mm=2.0)
    assert 10 < place.distance_low_mm <= place.distance_mm <= place.distance_high_mm < 75, place
    for wrong, reason in [(0.5, "on the chamber"), (-0.01, "must be positive")]:
        try:
            found = robot.locate(0, strain=wrong, deflection_mm=2.0)
        except NoPlace as refused:
            assert reason in str(refused), refused
        else:
            raise AssertionError(f"{wrong}: {found}")


def the_agent_is_found_again(robot: Robot) -> None:
    """After a silence the agent closes the connection, and tells a new one all pressures."""
    while robot.next_event(0.0) is not None:
        pass
    time.sleep(1.5)
    robot.pressure(0, 0.1)
    until = time.monotonic() + 10.0
    whiskers: set[int] = set()
    while whiskers != {0, 1} and time.monotonic() < until:
        robot.pressure(0, 0.1)
        event = robot.next_event(0.1)
        if isinstance(event, SetPressure):
            whiskers.add(event.whisker)
    assert whiskers == {0, 1}, whiskers


def a_closed_robot_says_so(robot: Robot) -> None:
    try:
        robot.pressure(0, 0.1)
    except AgentEnded:
        pass
    else:
        raise AssertionError("a pressure was sent to a closed robot")
    for _ in robot:
        # Events that nobody has taken yet; then the iteration ends.
        pass


async def with_asyncio(config: str) -> None:
    chambers = Chambers()

    async def listen(robot: AsyncRobot) -> None:
        async for event in robot:
            chambers.heard.append(event)
            if isinstance(event, SetPressure):
                chambers.hold(event)

    async with AsyncRobot(config) as robot:
        assert [whisker.whisker for whisker in await robot.whiskers()] == [0, 1]
        listening = asyncio.create_task(listen(robot))
        await robot.contact(7, deflection_mm=2.0, strain=0.01, distance_mm=50.0)
        until = time.monotonic() + SECONDS_MAX
        step, ends = 0, math.inf
        while time.monotonic() < min(until, ends):
            step += 1
            for whisker in (0, 1):
                await robot.pressure(whisker, chambers.pressure_mpa[whisker])
                await robot.contact(whisker, deflection_mm=2.0, strain=strain(step), distance_mm=55.0)
            await asyncio.sleep(0.05)
            if chambers.is_done() and math.isinf(ends):
                ends = time.monotonic() + 2.0
        assert chambers.is_done(), chambers.heard[-5:]
    await listening


def an_invalid_configuration_is_named(config: str) -> None:
    wrong = f"{config}.wrong"
    with open(config) as source, open(wrong, "w") as target:
        target.write(source.read().replace("pressure_max_mpa = 0.2", "pressure_max_mpa = 0.9"))
    try:
        Robot(wrong)
    except ValueError as refused:
        assert "pressure_max_mpa is 0.9" in str(refused), refused
    else:
        raise AssertionError("0.9 MPa was accepted")


def nothing_is_missing_for_asyncio() -> None:
    def told(kind: type) -> set[str]:
        return {name for name in vars(kind) if not name.startswith("_")}

    # Callbacks are for threads; tasks iterate.
    assert told(Robot) - told(AsyncRobot) == {"on"}, told(Robot) ^ told(AsyncRobot)
    for name in told(AsyncRobot) - {"robot"}:
        assert inspect.iscoroutinefunction(getattr(AsyncRobot, name)), name


def main() -> None:
    kind, config = sys.argv[1:]
    nothing_is_missing_for_asyncio()
    if kind == "sync":
        an_invalid_configuration_is_named(config)
        with_threads(config)
    else:
        asyncio.run(with_asyncio(config))
    print("ended")


if __name__ == "__main__":
    main()
