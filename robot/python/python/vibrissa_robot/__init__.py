"""The agent of a robot with soft whiskers: it keeps the contract with the supervisor, your program moves the air."""

from ._events import ContactPlace, Estimate, Event, NoPlace, ReadingGain, Refused, SetPressure, Test, WhiskerFacts
from ._link import AgentEnded
from ._robot import AsyncRobot, Robot

__all__ = [
    "AgentEnded",
    "AsyncRobot",
    "ContactPlace",
    "Estimate",
    "Event",
    "NoPlace",
    "ReadingGain",
    "Refused",
    "Robot",
    "SetPressure",
    "Test",
    "WhiskerFacts",
]
