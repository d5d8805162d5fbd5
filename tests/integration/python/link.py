"""What a robot in Python tells an agent that closes the connection, ends or panics: `link.py FOLDER_OF_THE_PACKAGE`."""

import json
import logging
import socket
import sys
import threading
import types
from typing import Any

HELLO = {
    "type": "hello",
    "version": 1,
    "whiskers": [{"array": "left", "whisker": 0, "pressure_mpa": 0.1, "pressure_max_mpa": 0.2}],
}


class Agent:
    """An agent of this process, which a test moves."""

    last: "Agent"

    def __init__(self, config: str, path: str, log: str) -> None:
        self.ended: Any = None
        self.listener = socket.socket(socket.AF_UNIX)
        self.listener.bind(path)
        self.listener.listen()
        Agent.last = self

    def accept(self) -> "tuple[socket.socket, Any]":
        link, _ = self.listener.accept()
        # A line that is missing must end the test.
        link.settimeout(30.0)
        lines = (json.loads(line) for line in link.makefile("rb"))
        assert next(lines)["type"] == "hello"
        return link, lines

    def failure(self) -> Any:
        return self.ended

    def stop(self) -> None:
        self.listener.close()


def said(lines: Any, count: int) -> "list[dict[str, Any]]":
    return [next(lines) for _ in range(count)]


def states_are_told_again(robot: Any, agent: Agent) -> None:
    link, lines = agent.accept()
    robot.driving(True)
    robot.task(True)
    robot.fault(0, gauge="OPEN", regulator="LEAK")
    robot.pressure(0, 0.1, regulator="OK")
    robot.motion(0, deflection_mm=2.0, ratio=0.5)
    robot.contact(0, deflection_mm=2.0, strain=0.01, tip=True, saturated=True)
    driving, task, fault, pressure, motion, contact = said(lines, 6)
    assert driving == {"type": "driving", "driving": True} and task == {"type": "task", "task": True}
    assert fault == {"type": "fault", "whisker": 0, "gauge": "OPEN", "regulator": "LEAK"}, fault
    assert motion == {"type": "motion", "whisker": 0, "deflection_mm": 2.0, "ratio": 0.5}, motion
    assert contact["saturated"] is True and pressure["regulator"] == "OK", contact
    robot.driving(False)
    link.shutdown(socket.SHUT_RDWR)
    link, lines = agent.accept()
    assert said(lines, 3) == [
        {"type": "driving", "driving": False},
        {"type": "task", "task": True},
        {"type": "fault", "whisker": 0, "gauge": "OPEN"},
    ]
    link.shutdown(socket.SHUT_RDWR)


def only_events_that_nobody_took_are_dropped(robot: Any, agent: Agent, set_pressure: type, most: int) -> None:
    link, _ = agent.accept()
    told = threading.Semaphore(0)
    robot.on(set_pressure)(lambda event: told.release())
    order = {"type": "set_pressure", "array": "left", "whisker": 0, "pressure_mpa": 0.1, "slew_mpa_per_s": 0.02}
    gain = {"type": "reading_gain", "array": "left", "whisker": 0, "reading_gain": 1.0}
    lines = [gain] * 3 + [order] * (most + 2)
    link.sendall(b"".join(json.dumps(line).encode() + b"\n" for line in [HELLO, *lines]))
    for _ in range(most + 2):
        assert told.acquire(timeout=30)
    assert robot.dropped == 3, robot.dropped
    link.shutdown(socket.SHUT_RDWR)


def the_end_of_an_agent_is_told(robot: Any, agent: Agent, ended: type) -> None:
    told = threading.Event()

    class Listen(logging.Handler):
        def emit(self, record: logging.LogRecord) -> None:
            if "has panicked" in record.getMessage():
                told.set()

    logging.getLogger("vibrissa_robot").addHandler(Listen())
    link, _ = agent.accept()
    agent.ended = "the agent has panicked"
    link.shutdown(socket.SHUT_RDWR)
    assert told.wait(timeout=30), "a program that only has callbacks must hear it"
    try:
        robot.pressure(0, 0.1)
    except ended as problem:
        assert str(problem) == "the agent has panicked", problem
    else:
        raise AssertionError("a pressure was sent to no agent")


def main() -> None:
    sys.path.insert(0, sys.argv[1])
    native: Any = types.ModuleType("vibrissa_robot._native")
    native.Agent = Agent
    sys.modules["vibrissa_robot._native"] = native
    import vibrissa_robot
    from vibrissa_robot._robot import EVENTS_MAX

    with vibrissa_robot.Robot("agent.toml") as robot:
        agent = Agent.last
        states_are_told_again(robot, agent)
        only_events_that_nobody_took_are_dropped(robot, agent, vibrissa_robot.SetPressure, EVENTS_MAX)
        the_end_of_an_agent_is_told(robot, agent, vibrissa_robot.AgentEnded)
    print("ended")


if __name__ == "__main__":
    main()
