"""The program ``status``: what a running node has and does."""

from __future__ import annotations

import argparse
import dataclasses
import json
import os
import sys
from collections.abc import Callable
from typing import Any

from drake_geom_ros.client import NoAnswerError, RefusedError, SceneGraphClient
from drake_geom_ros.program_parser import ProgramParser
from drake_geom_ros.ros.spinning import StopSignals
from drake_geom_ros.ros.status.gathering import Watcher, pause
from drake_geom_ros.ros.status.status_text import in_words

_NO_ANSWER, _STOPPED = 1, 130
_PAUSE = 0.5  # [s] between two readings


class _StoppedError(RuntimeError):
    """A signal came."""


class _Client(SceneGraphClient):
    """Ends its waits where a signal came, which raised at any moment may hit a destructor."""

    def __init__(self, signals: StopSignals, server: str, patience: float) -> None:
        super().__init__(server, patience)
        self._signals = signals

    def wait_for(self, fact: Callable[[], Any], what: str, end: float | None = None) -> Any:
        """Wait as the base does; raise _StoppedError once a signal came."""

        def holds() -> Any:
            if self._signals.received:
                raise _StoppedError
            return fact()

        return super().wait_for(holds, what, end)


def _arguments(words: list[str] | None) -> argparse.Namespace:
    parser = ProgramParser(
        description='Shows topics with rates, scene, waiting and stale frames, refusals, filters '
        'and leases of a running scene_graph node. It changes nothing.',
    )
    parser.add_argument('--node', default='/scene_graph', help='its full name (%(default)s)')
    parser.add_argument(
        '--timeout', type=float, default=5.0, metavar='S', help='how long to wait (%(default)s s)'
    )
    parser.add_argument('--json', action='store_true', help='one JSON object a reading')
    parser.add_argument('--watch', action='store_true', help='again and again, until Ctrl-C')
    options = parser.parse_args(words)
    if not options.timeout > 0.0:
        parser.error('--timeout must be positive')
    if not options.node.startswith('/'):
        options.node = f'/{options.node}'
    return options


def main(words: list[str] | None = None) -> int:
    """Show the status; return 0, or 1 where no node answers."""
    options = _arguments(words)
    try:
        with (
            StopSignals(once=True) as signals,
            _Client(signals, options.node, options.timeout) as client,
        ):
            watcher = Watcher(client, options.node)
            while True:
                status = watcher.status()
                if options.json:
                    print(json.dumps(dataclasses.asdict(status)), flush=True)
                else:
                    clear = '\033[2J\033[H' if options.watch and sys.stdout.isatty() else ''
                    print(f'{clear}{in_words(status)}', flush=True)
                if not options.watch:
                    return 0
                pause(client, _PAUSE)
    except (NoAnswerError, RefusedError) as error:
        domain = os.environ.get('ROS_DOMAIN_ID', '0')
        print(
            f'drake_geom_ros: no answer of {options.node} in ROS domain {domain}: {error}. Is it '
            'running and active, with this ROS_DOMAIN_ID and ROS_AUTOMATIC_DISCOVERY_RANGE? '
            '--node names another.',
            file=sys.stderr,
        )
        return _NO_ANSWER
    except _StoppedError:
        return _STOPPED
