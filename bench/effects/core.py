"""One scene in a process of its own, without ROS: what it imports, compiles, allocates, computes.

    python -m bench.effects.core FOLDER

FOLDER holds a rung (see ``rungs``); one line of JSON comes out. Nothing of ours, and no library,
is imported before the clock runs.
"""

from __future__ import annotations

import dataclasses
import json
import os
import statistics
import sys
import time
from pathlib import Path
from typing import Any

REACH = 0.1  # [m] of the signed distances that are asked for


class Watch:
    """Seconds, resident memory and new modules of each step."""

    def __init__(self) -> None:
        self.seconds: dict[str, float] = {}
        self.memory: dict[str, float] = {}
        self.modules: dict[str, list[str]] = {}
        self._known = set(sys.modules)
        self._start = time.perf_counter()

    def step(self, name: str) -> None:
        """End a step; what is looked up here is not counted to the next one."""
        self.seconds[name] = time.perf_counter() - self._start
        pages = int(Path('/proc/self/statm').read_text().split()[1])
        self.memory[name] = pages * os.sysconf('SC_PAGE_SIZE') / 1e6
        new = {module.partition('.')[0] for module in set(sys.modules) - self._known}
        self.modules[name] = sorted(new)
        self._known = set(sys.modules)
        self._start = time.perf_counter()


def cycles(context: Any, query: Any, vectors: list[Any]) -> tuple[Any, float]:
    """Pose and ask, a cycle a vector; return the effects of the last and the median seconds."""
    taken = []
    for vector in vectors:
        start = time.perf_counter()
        context.UpdateFramePoses(vector)
        query.ComputeSignedDistancePairwiseClosestPoints(REACH)
        taken.append(time.perf_counter() - start)
    return query.effects(), statistics.median(taken)


def counted(effects: Any) -> dict[str, Any]:
    """Return effects as plain numbers, without times."""
    plain = dataclasses.asdict(effects)
    del plain['seconds']
    return plain


def measure(folder: Path) -> dict[str, Any]:
    """Return what the rung in a folder does in this process, which must not have begun any."""
    watch = Watch()
    from drake_geom_ros.geometry import FramePoseVector, SceneGraph

    watch.step('core')
    from drake_geom_ros.scene_files import load_scene

    watch.step('scene files')
    graph = SceneGraph()
    graph.CreateDefaultContext()  # of nothing: the first compiled call loads most of Numba
    watch.step('numba')
    loaded = load_scene(folder / 'scene.yaml', graph)
    context = graph.CreateSharedContext()
    watch.step('scene')
    functions, kernels = compiled(context)
    watch.step('compile')
    vectors = posed(folder, loaded, FramePoseVector)
    query = graph.get_query_output_port().Eval(context)
    watch.step('poses')
    told = {}
    told['first'], _ = cycles(context, query, vectors[:1])
    watch.step('first query')
    told['moving'], moving = cycles(context, query, vectors[1:])
    told['resting'], resting = cycles(context, query, vectors[-1:] * 50)
    watch.step('cycles')
    return {
        'seconds': watch.seconds,
        'memory': watch.memory,
        'modules': watch.modules,
        'kernels': kernels,
        'functions': functions,
        'effects': {name: counted(effects) for name, effects in told.items()},
        'cycle': {'moving': moving, 'resting': resting},
        'allocated': allocated(graph, vectors),
    }


def compiled(context: Any) -> tuple[int, list[str]]:
    """Compile what the scene needs; return how many functions the cache lacked, and kernels."""
    from numba.core import event

    with event.install_recorder('numba:compile') as recorder:
        kernels = context.compile_kernels()
    return sum(entry.is_end for _, entry in recorder.buffer), kernels


def posed(folder: Path, loaded: Any, vector: Any) -> list[Any]:
    """Return the poses of the rung as a FramePoseVector a cycle."""
    import numpy as np

    by_name = {f'{source}::{name}': frame for (source, name), frame in loaded.frames.items()}
    by_name |= {name: frame for (_, name), frame in loaded.frames.items()}
    names = json.loads((folder / 'frames.json').read_text())
    ids = np.array([by_name[name].get_value() for name in names])
    return [vector.FromArrays(ids, poses) for poses in np.load(folder / 'poses.npy')]


def allocated(graph: Any, vectors: list[Any]) -> dict[str, float]:
    """Return the kilobytes [kB] that a context holds, and that a moving cycle takes at most."""
    import tracemalloc

    tracemalloc.start()
    before, _ = tracemalloc.get_traced_memory()
    context = graph.CreateDefaultContext()
    query = graph.get_query_output_port().Eval(context)
    half = len(vectors) // 2
    cycles(context, query, vectors[:half])
    held, _ = tracemalloc.get_traced_memory()
    tracemalloc.reset_peak()
    cycles(context, query, vectors[half : half + 20])
    after, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    return {'held': (held - before) / 1e3, 'cycle': (peak - min(held, after)) / 1e3}


if __name__ == '__main__':
    print(json.dumps(measure(Path(sys.argv[1]))))
