"""The process that takes what sensors see: started, answered, watched and started again.

The bytes of clouds never come into the node's interpreter, whose lock they would hold, and what is
done with them gives way to poses. A thread waits for what the process says. Where the process
ends, or is silent for too long, maps grow old, diagnostics say so, and another one is started.
"""

from __future__ import annotations

import math
import multiprocessing
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Mapping
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any, Protocol

from drake_geom_ros.geometry import ArgumentError
from drake_geom_ros.live.inputs.obstacle_records import Found, Place
from drake_geom_ros.live.scene.moments import UnknownYetError
from drake_geom_ros.ros.sensing.protocol import (
    ALIVE,
    COMPILING,
    Begin,
    Finish,
    MissedMessages,
    RefusalReason,
    RefusedMessage,
    SensorTopic,
    Task,
)

_MODULE = 'drake_geom_ros.ros.sensing'
_SILENCE = 10.0  # [s] after which a process that says nothing hangs
_STARTING = 120.0  # [s] the same where it starts, or may compile what knows new bodies
_OWN = ('Private_Clean:', 'Private_Dirty:')
_FIRST_PAUSE, _LONGEST_PAUSE = 0.5, 10.0  # [s] before another one is started; it doubles
_LONG_LIFE = 60.0  # [s] after which the first pause counts again


class PatientMap(Protocol):
    """The owner of the scene of a map, as ``Map``, which may be asked not to wait."""

    def begin(
        self,
        header: Any,
        waited: float,
        bodies_number: int,
        publisher: str,
        duration: float = 0.0,
        patience: float = 0.0,
    ) -> Place:
        """Do as ``Map.begin``, waiting for poses for at most ``patience`` [s]."""

    def finish(self, taken: Found) -> None:
        """Do as ``Map.finish``."""

    def miss(self, messages: int) -> None:
        """Count messages that were lost, or replaced by newer ones."""


class Listener(Protocol):
    """The receiver of counts and refusals of messages; a ``Guard`` is one."""

    def refused(self, name: str, reason: str) -> None:
        """Count and log that a message was refused."""

    def tell(self, about: str, what: str) -> None:
        """Warn of something that is no failure."""


class SensingProcess:
    """Keeps one process at work until it is closed."""

    def __init__(self, task: Task, maps: Mapping[str, PatientMap], listener: Listener) -> None:
        """Start it, which is not waited for; ``maps`` by input take what it finds."""
        self.trouble = 'the process that takes what sensors see has not started yet'
        self.starts = 0
        self._task, self._maps, self._listener = task, maps, listener
        self._closed = threading.Event()
        self._lock = threading.Lock()  # of the process
        self._process: subprocess.Popen[bytes] | None = None
        self._heard = time.monotonic()
        self._limit = _STARTING  # [s] for how long it may be silent
        self._hung = False
        self._has_other_topics = False  # than the process was sent
        # Sensors by input, frame and publisher, of which it has what is held from before.
        self._holding: set[tuple[str, ...]] = set()
        self._begun: tuple[str, ...] = ()  # the sensor of the message that was begun last
        self._thread = threading.Thread(target=self._serve, name='sensing', daemon=True)
        self._thread.start()

    def listen_to(self, topics: tuple[SensorTopic, ...], maps: Mapping[str, PatientMap]) -> None:
        """Have other topics listened to from now on, for other maps."""
        with self._lock:
            self._maps, self._task = maps, self._task._replace(topics=topics)
            self._has_other_topics = True

    def look(self) -> None:
        """End the process if it hangs; to be called every second or so."""
        with self._lock:
            silent = time.monotonic() - self._heard > self._limit
            if self._process is not None and silent and self._process.poll() is None:
                self._hung = True
                self._process.kill()

    def in_words(self) -> str:
        """Return which process it is, and what memory it takes."""
        with self._lock:
            process = self._process
        if process is None:
            return f'none runs; {self.starts} were started'
        return f'process {process.pid}, {_megabytes(process.pid)}, {self.starts} were started'

    def close(self) -> None:
        """End the process and the thread."""
        with self._lock:
            self._closed.set()
            if self._process is not None:
                self._process.kill()
        self._thread.join()

    def _serve(self) -> None:
        pause = _FIRST_PAUSE
        while not self._closed.is_set():
            start = time.monotonic()
            how = self._live_once()
            if self._closed.is_set():
                return
            self.trouble = f'{how}: nothing that sensors see is taken until another has started'
            self._listener.tell('sensing', self.trouble)
            if time.monotonic() - start > _LONG_LIFE:
                pause = _FIRST_PAUSE
            self._closed.wait(pause)
            pause = min(2.0 * pause, _LONGEST_PAUSE)

    def _live_once(self) -> str:
        """Start a process and answer it until it ends; return how it did, in words."""
        node_end, process_end = multiprocessing.Pipe()
        self._heard, self._limit, self._hung = time.monotonic(), _STARTING, False
        self._holding = set()
        with self._lock, process_end:
            if self._closed.is_set():
                node_end.close()
                return ''
            command = [sys.executable, '-m', _MODULE, str(process_end.fileno())]
            # Its input is the line that it hangs on: it ends with this process, however that dies.
            # What a terminal sends to the node is not for it.
            self._process = process = subprocess.Popen(
                command,
                stdin=subprocess.PIPE,
                pass_fds=[process_end.fileno()],
                start_new_session=True,
            )
            self.starts += 1
        end = ''
        try:
            with node_end:
                with self._lock:
                    task, self._has_other_topics = self._task, False
                node_end.send(task)
                while True:
                    self._answer(node_end, node_end.recv())
        except (EOFError, OSError):
            pass
        except Exception as error:  # whatever it is that no process of ours sends
            end = f'the process that takes what sensors see sent what nobody can read: {error!r}'
        with self._lock:
            process.kill()
            code = process.wait()
            self._process = None
        if process.stdin is not None:
            process.stdin.close()
        if self._hung:
            end = f'the process that takes what sensors see said nothing for {self._limit:g} s'
        return end or f'the process that takes what sensors see ended {_in_words(code)}'

    def _answer(self, node_end: Connection, said: Any) -> None:
        """Do what the process asks for."""
        if said == COMPILING:
            self._heard, self._limit = time.monotonic(), _STARTING
            return
        self.trouble = ''
        self._limit, limit = math.inf, _SILENCE  # it waits for this thread meanwhile
        if isinstance(said, Begin):
            # It answers at once: a thread that waited for a pose would delay all other sensors.
            arguments = said.header, said.waited, said.known, said.publisher, said.duration, 0.0
            self._begun = said.input, said.header.frame_id, said.publisher
            answer = self._done(lambda: self._map_of(said.input).begin(*arguments))
            if isinstance(answer, Place):
                if answer.bodies.bodies is not None:
                    limit = _STARTING
                if self._begun in self._holding:
                    answer = answer._replace(before=None)
            node_end.send(answer)
        elif isinstance(said, Finish):
            refusal = self._done(lambda: self._map_of(said.input).finish(said.found))
            if refusal is None:
                self._holding.add(self._begun)
            node_end.send(refusal)
        elif isinstance(said, RefusedMessage):
            self._listener.refused(said.told_as, said.reason)
        elif isinstance(said, MissedMessages):
            if said.input in self._maps:  # it was not removed meanwhile
                self._maps[said.input].miss(said.messages)
        elif said == ALIVE:
            with self._lock:
                topics = self._task.topics if self._has_other_topics else None
                self._has_other_topics = False
            node_end.send(topics)
        else:
            raise TypeError(type(said))
        self._heard, self._limit = time.monotonic(), limit

    def _map_of(self, name: str) -> PatientMap:
        if name not in self._maps:
            raise ArgumentError(f'the obstacle source {name!r} was removed')
        return self._maps[name]

    def _done(self, task: Callable[[], Place | None]) -> Place | RefusalReason | None:
        try:
            return task()
        except Exception as error:  # RuntimeError refuses; nobody foresaw others
            foreseen = isinstance(error, RuntimeError)
            reason = str(error) if foreseen else f'internal error: {error!r}'
            return RefusalReason(reason, isinstance(error, UnknownYetError))


def _in_words(code: int) -> str:
    """Return how a process ended."""
    if code >= 0:
        return f'with code {code}'
    return f'by {signal.Signals(-code).name}'


def _megabytes(pid: int) -> str:
    """Return in words the memory of a process without what it shares with others, as libraries."""
    try:
        rows = [row.split() for row in Path(f'/proc/{pid}/smaps_rollup').read_text().splitlines()]
        kilobytes = sum(int(row[1]) for row in rows if row[0] in _OWN)
    except (OSError, IndexError, ValueError):  # it is gone, or this is no Linux
        return 'of unknown memory'
    return f'{1024e-6 * kilobytes:.0f} MB of its own'
