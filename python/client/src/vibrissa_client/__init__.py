"""Client of the REST API of vibrissa, the supervisor of robots with soft whiskers."""

from . import models
from ._client import AsyncClient, Client
from ._curve import Curve
from ._events import Event
from ._request import ApiError

__all__ = ["ApiError", "AsyncClient", "Client", "Curve", "Event", "models"]
