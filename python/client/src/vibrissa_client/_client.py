"""The clients: one that waits, one for asyncio."""

from __future__ import annotations

import asyncio
import os
import time
from collections.abc import AsyncIterator, Iterator
from ssl import SSLContext
from types import TracebackType
from typing import Any, Optional, Union

import httpx

from . import models
from ._curve import Curve, after_cut, place, response
from ._events import Event, follow, follow_async
from ._operations import AsyncOperations, Operations
from ._request import PASSING, Request, answer, pause_s

URL = "http://127.0.0.1:8080"
TIMEOUT = httpx.Timeout(30.0)


def _options(
    url: Optional[str], token: Optional[str], verify: Union[bool, SSLContext]
) -> tuple[str, dict[str, str], Union[bool, SSLContext]]:
    url = url or os.environ.get("VIBRISSA_URL") or URL
    token = token or os.environ.get("VIBRISSA_TOKEN")
    return url, ({"Authorization": f"Bearer {token}"} if token else {}), verify


class Client(Operations):
    """A client of the REST API.

    Args:
        url: Address of a supervisor; by default the variable `VIBRISSA_URL`, or http://127.0.0.1:8080.
        token: API token; by default the variable `VIBRISSA_TOKEN`. On 127.0.0.1 a supervisor may need none.
        verify: Whether to verify the server's certificate, or a context with certificates of your own.
        retries: How often a request is sent again after a lost connection or an answer 429, 503 or 504. A change has a
            key, by which the service does it once.
    """

    def __init__(
        self,
        url: Optional[str] = None,
        token: Optional[str] = None,
        *,
        verify: Union[bool, SSLContext] = True,
        retries: int = 3,
    ) -> None:
        url, headers, verify = _options(url, token, verify)
        self._http = httpx.Client(base_url=url, headers=headers, timeout=TIMEOUT, verify=verify)
        self._retries = retries

    def __enter__(self) -> Client:
        return self

    def __exit__(
        self, kind: Optional[type[BaseException]], raised: Optional[BaseException], trace: Optional[TracebackType]
    ) -> None:
        self.close()

    def close(self) -> None:
        """Closes the connections."""
        self._http.close()

    def _send(self, request: Request) -> Any:
        headers, query = request.all_headers(), request.parameters()
        for attempt in range(self._retries + 1):
            is_last = attempt == self._retries
            try:
                got = self._http.request(request.method, request.path, params=query, headers=headers, json=request.body)
            except httpx.TransportError:
                if is_last:
                    raise
                time.sleep(pause_s(attempt))
                continue
            if is_last or got.status_code not in PASSING:
                break
            time.sleep(pause_s(attempt, got))
        return answer(request, got)

    def events(self, *, fleet: Optional[str] = None, last_event_id: Optional[str] = None) -> Iterator[Event]:
        """Changes as they happen, without end: a lost connection is made again, from the last event on.

        Raises:
            ApiError: The service refuses the request, for example because the token has expired.
        """
        return follow(self._http, fleet, last_event_id)

    def response_curve(self, whisker: models.Whisker) -> Curve:
        """The sensitivity of a whisker along its length: predicted when it was whole, predicted now, and measured."""
        parts = place(whisker)
        return response(parts, self.get_model(*parts))

    def what_if(self, whisker: models.Whisker, length_mm: float) -> Curve:
        """The sensitivity of a whisker if it were cut to a length, without and with its compensation. Changes nothing."""
        parts = place(whisker)
        return after_cut(parts, length_mm, self.get_what_if(*parts, length_mm=length_mm))


class AsyncClient(AsyncOperations):
    """The same for asyncio: each operation is a coroutine, each list an asynchronous iterator."""

    def __init__(
        self,
        url: Optional[str] = None,
        token: Optional[str] = None,
        *,
        verify: Union[bool, SSLContext] = True,
        retries: int = 3,
    ) -> None:
        url, headers, verify = _options(url, token, verify)
        self._http = httpx.AsyncClient(base_url=url, headers=headers, timeout=TIMEOUT, verify=verify)
        self._retries = retries

    async def __aenter__(self) -> AsyncClient:
        return self

    async def __aexit__(
        self, kind: Optional[type[BaseException]], raised: Optional[BaseException], trace: Optional[TracebackType]
    ) -> None:
        await self.close()

    async def close(self) -> None:
        """Closes the connections."""
        await self._http.aclose()

    async def _send(self, request: Request) -> Any:
        headers, query = request.all_headers(), request.parameters()
        for attempt in range(self._retries + 1):
            is_last = attempt == self._retries
            try:
                got = await self._http.request(
                    request.method, request.path, params=query, headers=headers, json=request.body
                )
            except httpx.TransportError:
                if is_last:
                    raise
                await asyncio.sleep(pause_s(attempt))
                continue
            if is_last or got.status_code not in PASSING:
                break
            await asyncio.sleep(pause_s(attempt, got))
        return answer(request, got)

    def events(self, *, fleet: Optional[str] = None, last_event_id: Optional[str] = None) -> AsyncIterator[Event]:
        """Changes as they happen, without end: a lost connection is made again, from the last event on.

        Raises:
            ApiError: The service refuses the request, for example because the token has expired.
        """
        return follow_async(self._http, fleet, last_event_id)

    async def response_curve(self, whisker: models.Whisker) -> Curve:
        """The sensitivity of a whisker along its length: predicted when it was whole, predicted now, and measured."""
        parts = place(whisker)
        return response(parts, await self.get_model(*parts))

    async def what_if(self, whisker: models.Whisker, length_mm: float) -> Curve:
        """The sensitivity of a whisker if it were cut to a length, without and with its compensation. Changes nothing."""
        parts = place(whisker)
        return after_cut(parts, length_mm, await self.get_what_if(*parts, length_mm=length_mm))
