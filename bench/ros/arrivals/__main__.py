"""How long cycles wait while something large arrives, beside the gaps of an idle node.

    ./run exec python -m bench.ros.arrivals [--turns 5] [--kinds robot mesh]

A hand is posed at 100 Hz, each pose is a cycle, and in the middle something arrives: by topic or
by service. A gap is the time between two results, as another process hears them. In each turn the
node is left alone for as long as the arrival takes (1 s at least), then it is sent: the longest
gaps of all turns of one run are compared, median and 99th percentile. Milliseconds.

On a machine that does other work run it with ``nice -n -20``. In a real-time class all threads
have the same priority, and while two of them compute on two cores the hand waits for a time slice
of 100 ms: so it is while a mesh is registered (109 ms instead of 35) or cross_check begins.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from bench.ros.arrivals.kinds import KINDS, Kind, write
from bench.ros.arrivals.stream import Stream
from bench.ros.processes import Processes
from drake_geom_ros.client import SceneGraphClient

NODE = 'drake_geom_ros.ros.scene_graph_node'
IDLE = 1.0  # [s] at least
AFTER = 0.3  # [s] that count as well: what is published and tidied up once it is answered
REST = 1.0  # [s] between two turns
LIMIT = 50.0  # [ms] that cycles may wait for anything


def longest(arrivals: NDArray[np.float64], start: float, end: float) -> float:
    """Return the longest gap [ms] between two results that reaches into a span [s].

    One after which nothing came ends with the span. Raises RuntimeError without any result.
    """
    if not arrivals.size:
        raise RuntimeError('no result came: is the hand posed, and the node active?')
    begun, ended = arrivals, np.append(arrivals[1:], max(end, arrivals[-1]))
    return float(np.max((ended - begun)[(ended > start) & (begun < end)], initial=0.0)) * 1e3


def measure(kind: Kind, turns: int) -> str:
    """Return a row of the table."""
    idle, busy, took = [], [], []
    with tempfile.TemporaryDirectory() as folder, Processes() as processes:
        scene = write(kind, Path(folder))
        processes.start(NODE, scene_file=scene, max_distance=0.05, **kind.parameters)
        with SceneGraphClient(patience=300.0) as client, Stream() as stream:
            send, take_back = kind.ways(client)
            seconds = IDLE
            for _ in range(turns + 1):  # the first loads what is compiled
                time.sleep(REST)
                stream.arrivals()
                start = time.monotonic()
                time.sleep(seconds)
                begin = time.monotonic()
                send()
                end = time.monotonic()
                time.sleep(AFTER + REST)
                arrivals = stream.arrivals()
                idle.append(longest(arrivals, start, begin))
                busy.append(longest(arrivals, begin, end + AFTER))
                took.append(end - begin)
                seconds = max(IDLE, end - begin)
                take_back()
    cells = [f'{value:9.1f}' for all in (idle, busy) for value in np.percentile(all[1:], (50, 99))]
    over = '  more than 50' if np.median(busy[1:]) > LIMIT else ''
    return f'{kind.name:33}{np.median(took[1:]) * 1e3:9.0f}{"".join(cells)}{over}'


def main() -> None:
    """Measure and print the table."""
    parser = argparse.ArgumentParser(
        prog='python -m bench.ros.arrivals', description=__doc__.split('\n')[0]
    )
    parser.add_argument('--turns', type=int, default=5)
    parser.add_argument('--kinds', nargs='+', default=[''], help='beginnings of names')
    options = parser.parse_args()
    titles = ''.join(f'{c:>9}' for c in ('takes', 'idle p50', 'p99', 'gap p50', 'p99'))
    print(f'{"arrives":33}{titles}   [ms]')
    for kind in KINDS:
        if kind.name.startswith(tuple(options.kinds)):
            print(measure(kind, options.turns), flush=True)


if __name__ == '__main__':
    main()
