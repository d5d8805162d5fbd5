"""Prints each event as a line of JSON: `follow.py sync` or `follow.py async`."""

import asyncio
import json
import sys

from vibrissa_client import AsyncClient, Client, Event


def show(event: Event) -> None:
    print(json.dumps({"kind": event.kind, "id": event.id, "change": event.change}), flush=True)


async def follow() -> None:
    async with AsyncClient() as client:
        async for event in client.events(fleet="f"):
            show(event)


if sys.argv[1] == "async":
    asyncio.run(follow())
else:
    for event in Client().events(fleet="f"):
        show(event)
