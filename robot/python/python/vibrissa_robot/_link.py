"""The connection to the agent in this process, made again whenever the agent closes it."""

from __future__ import annotations

import json
import logging
import shutil
import socket
import struct
import tempfile
import threading
import time
from collections.abc import Callable, Iterator
from os import PathLike
from typing import Any, Optional, Union

from . import _native
from ._events import line_of

#: Longest wait for the agent to listen or to read, in seconds.
PATIENCE_S = 5.0
#: Pause between two attempts to connect, in seconds.
PAUSE_S = 0.05
_LOG = logging.getLogger("vibrissa_robot")


class AgentEnded(RuntimeError):
    """The agent has ended: it could not start, or the robot was closed."""


class Link:
    """An agent, and the socket to it."""

    def __init__(
        self,
        config: Union[str, PathLike[str]],
        log: str,
        receive: Callable[[dict[str, Any]], None],
        states: Callable[[], bytes],
    ) -> None:
        # Only this user can enter the folder.
        self._folder = tempfile.mkdtemp(prefix="vibrissa-robot-")
        self._path = f"{self._folder}/driver"
        self._receive = receive
        # Lines that a new connection begins with: the agent forgets states of one that has ended.
        self._states = states
        self._connected = threading.Condition()
        self._socket: Optional[socket.socket] = None
        self.is_closed = False
        try:
            self._agent = _native.Agent(config, self._path, log)
        except BaseException:
            shutil.rmtree(self._folder, ignore_errors=True)
            raise
        self._thread = threading.Thread(target=self._run, name="vibrissa-robot-lines", daemon=True)
        self._thread.start()

    def ended(self) -> Optional[AgentEnded]:
        """Why the agent has ended, if it has."""
        if self.is_closed:
            return AgentEnded("the robot is closed")
        failure = self._agent.failure()
        return None if failure is None else AgentEnded(failure)

    def send(self, line: bytes) -> None:
        """Sends a line, at most PATIENCE_S after the agent can take it.

        Raises:
            AgentEnded: There is no agent any more.
            TimeoutError: The agent takes no line.
        """
        until = time.monotonic() + PATIENCE_S
        with self._connected:
            while True:
                ended = self.ended()
                if ended is not None:
                    raise ended
                if self._socket is not None:
                    try:
                        self._socket.sendall(line)
                        return
                    except OSError:
                        # A part of the line may be on its way: only a new connection is sure to begin with a line.
                        self._drop()
                if not self._connected.wait(timeout=min(0.2, max(0.0, until - time.monotonic()))):
                    if time.monotonic() >= until:
                        raise TimeoutError("the agent takes no line")

    def close(self) -> None:
        """Stops the agent, which says farewell to the supervisor."""
        if self.is_closed:
            return
        self.is_closed = True
        self._agent.stop()
        with self._connected:
            self._drop()
        if threading.current_thread() is not self._thread:
            self._thread.join(PATIENCE_S)
        shutil.rmtree(self._folder, ignore_errors=True)

    def _drop(self) -> None:
        if self._socket is not None:
            try:
                self._socket.shutdown(socket.SHUT_RDWR)
            except OSError:
                pass
            self._socket.close()
            self._socket = None

    def _run(self) -> None:
        while (ended := self.ended()) is None:
            opened = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
            try:
                opened.connect(self._path)
                hello = line_of("hello", {"version": 1, "name": "vibrissa-robot for Python"})
                opened.sendall(hello + self._states())
            except OSError:
                opened.close()
                time.sleep(PAUSE_S)
                continue
            # An agent that reads nothing must not stop the program.
            opened.setsockopt(socket.SOL_SOCKET, socket.SO_SNDTIMEO, struct.pack("ll", int(PATIENCE_S), 0))
            with self._connected:
                self._socket = opened
                self._connected.notify_all()
            for line in _lines(opened):
                self._receive(line)
            with self._connected:
                if self._socket is opened:
                    self._drop()
            time.sleep(PAUSE_S)
        if not self.is_closed:
            # A program that only has callbacks sends nothing by which it would notice.
            _LOG.error("the agent has ended: %s", ended)
        with self._connected:
            self._connected.notify_all()


def _lines(opened: socket.socket) -> Iterator[dict[str, Any]]:
    try:
        with opened.makefile("rb") as stream:
            for line in stream:
                yield json.loads(line)
    except (OSError, ValueError):
        # Closed by either side.
        return
