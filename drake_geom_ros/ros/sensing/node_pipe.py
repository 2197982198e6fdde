"""The pipe from the process of sensors to its node, with signs of life while kernels compile."""

from __future__ import annotations

import threading
import time
from multiprocessing.connection import Connection
from typing import Any

from drake_geom_ros.ros.sensing.protocol import COMPILING

_SIGN = 1.0  # [s] between two signs of life
_LONGEST = 1800.0  # [s] for which compiling is believed


class NodePipe:
    """A pipe to the node for one thread, beside which another one gives signs of life.

    Compiling may take longer than a process may be silent: on a busy machine, or where another
    process compiles the same kernel, which is waited for. Who ends it then has it begin anew, for
    ever.
    """

    def __init__(self, connection: Connection) -> None:
        self._connection = connection
        self._lock = threading.Lock()  # of what is sent
        self._until = 0.0  # [s] monotonic time up to which there are signs of life
        threading.Thread(target=self._give_signs, name='signs of life', daemon=True).start()

    def may_compile(self) -> None:
        """Give signs of life until the next message is sent."""
        self._until = time.monotonic() + _LONGEST

    def send(self, message: Any) -> None:
        """Send a message; raises OSError if the node is gone."""
        self._until = 0.0
        with self._lock:
            self._connection.send(message)

    def recv(self) -> Any:
        """Return the next message of the node; raises EOFError if it is gone."""
        return self._connection.recv()

    def _give_signs(self) -> None:
        while True:
            time.sleep(_SIGN)
            with self._lock:
                if time.monotonic() < self._until:
                    try:
                        self._connection.send(COMPILING)
                    except OSError:  # it is gone, which the other thread notices
                        return
