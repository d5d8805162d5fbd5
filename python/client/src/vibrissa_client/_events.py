"""Live events (server-sent events) that survive lost connections."""

from __future__ import annotations

import asyncio
import json
import time
from collections.abc import AsyncIterator, Iterator
from dataclasses import dataclass
from typing import Any, Literal, Optional, cast

import httpx
from httpx_sse import ServerSentEvent, SSEError, aconnect_sse, connect_sse

from . import models
from ._request import PASSING, ApiError, pause_s, refusal

PATH = "/v1/events"
#: The service sends something at least every 15 s; a longer silence is a lost connection.
SILENCE_S = 45.0


@dataclass(frozen=True)
class Event:
    """Something changed. Read the changed object itself from the API."""

    #: `change`; or `reset`: changes may have been missed, read everything again.
    kind: Literal["change", "reset"]
    #: ID for `last_event_id`, with which a later program continues; empty in a `reset` before the first change.
    id: str
    #: What changed; None in a `reset`.
    change: Optional[models.Event]


class _Position:
    """Where the stream continues after a lost connection."""

    def __init__(self, fleet: Optional[str], last_event_id: Optional[str]) -> None:
        self.fleet, self.last_event_id, self.failures = fleet, last_event_id, 0
        self.has_lost = False

    def arguments(self) -> dict[str, Any]:
        headers = {} if self.last_event_id is None else {"Last-Event-ID": self.last_event_id}
        query = {} if self.fleet is None else {"fleet": self.fleet}
        timeout = httpx.Timeout(30.0, read=SILENCE_S)
        return {"headers": headers, "params": query, "timeout": timeout}

    def event(self, received: ServerSentEvent) -> Optional[Event]:
        """An event for the caller; None for the words that only keep the connection alive."""
        self.failures = 0
        if received.id:
            self.last_event_id = received.id
        if received.event == "reset":
            return Event("reset", received.id, None)
        if received.event != "change":
            return None
        return Event("change", received.id, cast(models.Event, json.loads(received.data)))

    def opened(self) -> Optional[Event]:
        """A `reset` if the stream is open again, and no ID tells where the lost one had ended."""
        has_lost, self.has_lost = self.has_lost, True
        return Event("reset", "", None) if has_lost and self.last_event_id is None else None

    def failed(self, response: Optional[httpx.Response] = None) -> float:
        """Seconds until the next attempt."""
        self.failures += 1
        return pause_s(self.failures - 1, response)


def refused(response: httpx.Response) -> Optional[ApiError]:
    """The error of an answer that no later attempt can change."""
    return None if response.status_code in PASSING else refusal(response)


def follow(http: httpx.Client, fleet: Optional[str], last_event_id: Optional[str]) -> Iterator[Event]:
    """Events without end. A lost connection is made again, from the last event on."""
    at = _Position(fleet, last_event_id)
    while True:
        response: Optional[httpx.Response] = None
        try:
            with connect_sse(http, "GET", PATH, **at.arguments()) as source:
                response = source.response
                if not response.is_success:
                    response.read()
                    error = refused(response)
                    if error is not None:
                        raise error
                else:
                    reset = at.opened()
                    if reset is not None:
                        yield reset
                    for received in source.iter_sse():
                        event = at.event(received)
                        if event is not None:
                            yield event
        except (httpx.TransportError, SSEError, ValueError):
            pass
        time.sleep(at.failed(response))


async def follow_async(
    http: httpx.AsyncClient, fleet: Optional[str], last_event_id: Optional[str]
) -> AsyncIterator[Event]:
    """The same for asyncio."""
    at = _Position(fleet, last_event_id)
    while True:
        response: Optional[httpx.Response] = None
        try:
            async with aconnect_sse(http, "GET", PATH, **at.arguments()) as source:
                response = source.response
                if not response.is_success:
                    await response.aread()
                    error = refused(response)
                    if error is not None:
                        raise error
                else:
                    reset = at.opened()
                    if reset is not None:
                        yield reset
                    async for received in source.aiter_sse():
                        event = at.event(received)
                        if event is not None:
                            yield event
        except (httpx.TransportError, SSEError, ValueError):
            pass
        await asyncio.sleep(at.failed(response))
