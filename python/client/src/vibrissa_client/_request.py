"""Requests, and what their answers mean. Nothing here uses the network."""

from __future__ import annotations

import random
import uuid
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Optional, Union, cast
from urllib.parse import quote

import httpx

from . import models

#: Answers after which the same request may succeed: too many requests, and a supervisor or database that is away. 502 is a
#: proxy's answer while the supervisor behind it restarts.
PASSING = frozenset({429, 502, 503, 504})


@dataclass
class Request:
    """A request to the REST API; a value of None is left out."""

    method: str
    path: str
    query: Mapping[str, object] = field(default_factory=dict)
    headers: Mapping[str, Optional[str]] = field(default_factory=dict)
    body: object = None
    is_text: bool = False

    def parameters(self) -> dict[str, str]:
        """The query, in the words of the API."""
        return {name: _word(value) for name, value in self.query.items() if value is not None}

    def all_headers(self) -> dict[str, str]:
        """The headers. A change gets a key, so that it is done once although it may be sent again."""
        headers = {name: value for name, value in self.headers.items() if value is not None}
        if self.method != "GET":
            headers.setdefault("Idempotency-Key", str(uuid.uuid4()))
        return headers


class ApiError(Exception):
    """The service refused a request, or could not answer it."""

    def __init__(self, status: int, problem: Optional[models.Problem], text: str) -> None:
        self.status = status
        #: The problem document (RFC 9457); None if something else answered, such as a proxy.
        self.problem = problem
        said = f"{problem['title']}: {problem['detail']}" if problem else text[:500]
        errors = problem.get("errors", []) if problem else []
        named = "".join(f"; {one['field']}: {one['detail']}" for one in errors)
        super().__init__(f"{status} {said}{named}")


def quoted(part: Union[str, int]) -> str:
    """A part of a path."""
    return quote(str(part), safe="")


def _word(value: object) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    return str(value)


def refusal(response: httpx.Response) -> Optional[ApiError]:
    """The error that a complete answer means, if any."""
    if response.is_success:
        return None
    problem: Optional[models.Problem] = None
    try:
        body = response.json()
        if isinstance(body, dict) and {"title", "detail"} <= body.keys():
            problem = cast(models.Problem, body)
    except ValueError:
        pass
    return ApiError(response.status_code, problem, response.text)


def answer(request: Request, response: httpx.Response) -> Any:
    """The body of an answer.

    Raises:
        ApiError: The service refused the request, or its answer is no JSON.
    """
    error = refusal(response)
    if error is not None:
        raise error
    if request.is_text:
        return response.text
    if not response.content:
        return None
    try:
        return response.json()
    except ValueError:
        raise ApiError(response.status_code, None, f"no JSON: {response.text[:200]}") from None


def pause_s(attempt: int, response: Optional[httpx.Response] = None) -> float:
    """Seconds until the next attempt, with chance in it, so that many clients do not return at once."""
    try:
        told = float(response.headers.get("Retry-After", "0")) if response is not None else 0.0
    except ValueError:
        told = 0.0
    return min(30.0, max(told, 0.25 * 2.0 ** min(attempt, 7))) * random.uniform(0.75, 1.0) + min(told, 30.0) * 0.25
