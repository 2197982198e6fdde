"""What the page in the browser costs: many bodies at 20 Hz, or hours beside the demo's node.

    ./run exec python -m bench.viewer crowd [--bodies 200 2000]
    ./run exec python -m bench.viewer beside [--minutes 10]

``crowd`` poses bodies of five shapes 20 times a second and asks all distances up to 0.15 m; told
are the processor time of the page, a share of one core, how often a headless Chromium, if there is
one, draws, and how long it takes for a screenshot (it goes to the folder of temporary files).
``beside`` runs node, player and viewer of the demo with such a browser, and tells their memory and
their share of a core each minute.
"""

from __future__ import annotations

import argparse
import contextlib
import importlib.util
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from bench.viewer.browser import PROGRAM, Browser
from drake_geom_ros.cross_check.bodies import Body
from drake_geom_ros.geometry import FramePoseVector
from truth.judging.asking import BodyScene

RATE = 20.0  # [Hz]
MAX_DISTANCE = 0.15  # [m]
_INSIDE = "document.getElementById('picture').contentWindow"
# How often viser's page has drawn so far.
DRAWN = f'{_INSIDE}.__viserTestpoints.rendererInfo.render.frame'
SETTLING = 10.0  # [s] until the page is drawn and shown
_BODIES = (
    *(Body('Sphere', (0.05,)), Body('Box', (0.1, 0.08, 0.06)), Body('Capsule', (0.03, 0.1))),
    *(Body('Cylinder', (0.04, 0.1)), Body('Ellipsoid', (0.03, 0.05, 0.04))),
)
_SPACING = 0.27  # [m], with which 200 bodies have some 300 pairs within MAX_DISTANCE
_SWAY = 0.02  # [m]


class Crowd:
    """Bodies that sway about their places."""

    def __init__(self, count: int) -> None:
        from drake_geom_ros.viewing.local_scene import LocalScene

        random = np.random.default_rng(0)
        crowd = BodyScene([_BODIES[k % len(_BODIES)] for k in range(count)])
        self._frames = crowd.frames
        self._places = random.uniform(0.0, _SPACING * np.cbrt(count), (count, 3))
        turns = random.normal(size=(count, 4))
        self._turns = turns / np.linalg.norm(turns, axis=1, keepdims=True)
        self.scene = LocalScene(crowd.graph, crowd.graph.CreateSharedContext(partial=True))
        self.pose(0.0)

    def pose(self, moment: float) -> None:
        """Pose all bodies as they are at a time [s]."""
        phases = np.arange(len(self._places))[:, None]
        places = self._places + _SWAY * np.sin(moment + phases)
        poses = np.hstack([places, self._turns])
        self.scene.pose(FramePoseVector.FromArrays(self._frames, poses))


@contextlib.contextmanager
def browsing(url: str) -> Iterator[Any]:
    """Show a page in a headless Chromium, if there is one; yields it, or None."""
    if PROGRAM is None:
        print('without a browser: there is no chromium')
        yield None
        return
    browser = Browser(url)
    try:
        time.sleep(SETTLING)
        yield browser
    finally:
        browser.close()


def crowd(count: int, seconds: float) -> str:
    """Return what a page of so many bodies costs."""
    from drake_geom_ros.viewing.page.page import Page
    from drake_geom_ros.viewing.page.serving import open_server

    bodies = Crowd(count)
    page = Page(open_server(port=18300), bodies.scene, max_distance=MAX_DISTANCE)
    with browsing(f'http://{page.host}:{page.port}') as browser:
        before = 0 if browser is None else browser.ask(DRAWN)
        used, start = time.process_time(), time.monotonic()
        for k in range(round(RATE * seconds)):
            bodies.pose(k / RATE)
            time.sleep(max(0.0, start + (k + 1) / RATE - time.monotonic()))
        lasted = time.monotonic() - start
        share = (time.process_time() - used) / lasted
        drawn = picture = float('nan')
        if browser is not None:
            drawn = (browser.ask(DRAWN) - before) / lasted
            start = time.monotonic()
            browser.screenshot(Path(tempfile.gettempdir()) / f'crowd_{count}.png')
            picture = time.monotonic() - start
    pairs = len(page.moment.pairs)
    page.close()
    shares = f'{100 * share:6.1f} % of a core {drawn:6.1f} drawn/s {picture:6.1f} s a picture'
    return f'{count:6} bodies {pairs:6} pairs {shares}'


def beside(minutes: float) -> None:
    """Print memory [MB] and shares of a core of the demo's processes, each minute."""
    from bench.ros.beside import NODE, VIEWER, used
    from bench.ros.driver import MOTION, PLAYER, SCENE
    from bench.ros.processes import Processes, memory

    with Processes() as processes:
        files = {'scene_file': SCENE, 'trajectory_file': MOTION}
        started = {
            'node': processes.start(NODE, scene_file=SCENE, max_distance=0.1),
            'player': processes.start(PLAYER, **files, rate=100.0),
            'viewer': processes.start(VIEWER, port=18301),
        }
        time.sleep(SETTLING)
        print('minute' + ''.join(f'{name + " MB":>12}{"% of core":>10}' for name in started))
        with browsing('http://127.0.0.1:18301'):
            before = {name: used(each.pid) for name, each in started.items()}
            for minute in range(1, round(minutes) + 1):
                time.sleep(60.0)
                cells = [f'{minute:6}']
                for name, each in started.items():
                    now = used(each.pid)
                    share = 100.0 * (now - before[name]) / 60.0
                    before[name] = now
                    cells.append(f'{memory(each.pid):12.1f}{share:10.1f}')
                print(''.join(cells), flush=True)


def main() -> None:
    """Measure what is asked for."""
    parser = argparse.ArgumentParser(
        prog='python -m bench.viewer', description=__doc__.split('\n')[0]
    )
    parser.add_argument('what', choices=('crowd', 'beside'))
    parser.add_argument('--bodies', type=int, nargs='+', default=[200, 2000])
    parser.add_argument('--seconds', type=float, default=15.0)
    parser.add_argument('--minutes', type=float, default=10.0)
    options = parser.parse_args()
    if importlib.util.find_spec('viser') is None:
        parser.error('viser is not installed: `./run view --help` installs it')
    if options.what == 'beside':
        beside(options.minutes)
        return
    for count in options.bodies:
        print(crowd(count, options.seconds), flush=True)


if __name__ == '__main__':
    main()
