"""What a cycle costs right after other work, as every cycle of a robot does.

    ./run exec python -m bench.costs.cold [SCENE ...]

In turns, the process does something else, then asks for the penetrations in ten cycles in a row.
Medians over the turns, in microseconds, of the first cycle, the second and so on: what was done in
between has taken the processor's caches, and the first cycles bring back what they need.
"""

from __future__ import annotations

import ast
import gc
import inspect
import sys
import time
from collections.abc import Callable

import numpy as np

from bench.peers.motion import PACES
from bench.peers.ours import Side
from bench.peers.scenes import build
from bench.peers.timing import TURN_CYCLES, back_and_forth

TURNS = 60
POSES = 100
SCENES = ('spheres-50', 'mixed-50', 'arms')


def sweep(megabytes: int) -> Callable[[], object]:
    """Return what reads and writes so many megabytes."""
    memory = np.zeros(megabytes << 20, dtype=np.uint8)
    return lambda: np.add(memory, 1, out=memory)


def stay_awake(seconds: float) -> None:
    """Read the clock, and touch nothing else."""
    until = time.perf_counter() + seconds
    while time.perf_counter() < until:
        pass


def other_work() -> dict[str, Callable[[], object]]:
    """Return what is done in between, by name."""
    source = inspect.getsource(inspect)
    return {
        'nothing': lambda: None,
        '8 MB swept': sweep(8),
        '128 MB swept': sweep(128),
        'a file parsed': lambda: ast.parse(source),
        'awake for 10 ms': lambda: stay_awake(0.01),
        'asleep for 10 ms': lambda: time.sleep(0.01),
    }


def after(work: Callable[[], object], side: Side, layouts: list[object]) -> list[float]:
    """Return the median time [us] of each cycle of a turn that begins after some work."""
    spent = np.empty((TURNS, TURN_CYCLES))
    for turn in range(TURNS):
        work()
        for k in range(TURN_CYCLES):
            poses = layouts[back_and_forth(turn * TURN_CYCLES + k, POSES)]
            start = time.perf_counter()
            side.set_poses(poses)
            side.answers['penetration']()
            spent[turn, k] = time.perf_counter() - start
    return [float(us) for us in 1e6 * np.median(spent, axis=0)]


def main(names: list[str]) -> None:
    print(f'{"scene":12} {"pace":6} {"before":18} us of the first cycle, the second, ...')
    for name in names or SCENES:
        scene = build(name)
        side = Side(scene)
        for pace in PACES[:2]:
            layouts = [side.layout(poses) for poses in scene.motion.poses(POSES, 0, pace)]
            after(lambda: None, side, layouts)  # compiles
            gc.collect()
            gc.disable()
            for label, work in other_work().items():
                times = ' '.join(f'{us:6.1f}' for us in after(work, side, layouts))
                print(f'{name:12} {pace:6} {label:18} {times}', flush=True)
            gc.enable()


if __name__ == '__main__':
    main(sys.argv[1:])
