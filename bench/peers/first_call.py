"""What the first calls cost: import, compilation or its cache, then a call as usual.

Started in a process of its own, with a folder for compiled code that is empty or was filled by
the process before::

    NUMBA_CACHE_DIR=/empty/folder python -m bench.peers.first_call mixed-50
"""

from __future__ import annotations

import importlib
import json
import os
import subprocess
import sys
import tempfile
import time


def measure(name: str) -> dict[str, float]:
    """Return the seconds of each step in this process, which must not have begun any."""
    start = time.perf_counter()
    importlib.import_module('drake_geom_ros.geometry')
    taken = {'import': time.perf_counter() - start}
    from bench.peers.ours import Side
    from bench.peers.scenes import build

    scene = build(name)
    start = time.perf_counter()
    side = Side(scene, loaded=False)
    taken['scene'] = time.perf_counter() - start
    for cycle, X_WFs in enumerate(scene.motion.poses(2, seed=0)):
        for query in ('penetration', 'near', 'points'):
            start = time.perf_counter()
            side.set_poses(X_WFs)
            side.answers[query]()
            taken[f'{("first", "next")[cycle]} {query}'] = time.perf_counter() - start
    return taken


def cold_and_cached(name: str) -> dict[str, dict[str, float]]:
    """Return the seconds of each step without and with compiled code on disk."""
    with tempfile.TemporaryDirectory(prefix='bench-numba-') as folder:
        path = os.pathsep.join(entry for entry in sys.path if entry)
        environment = {**os.environ, 'NUMBA_CACHE_DIR': folder, 'PYTHONPATH': path}
        command = [sys.executable, '-m', 'bench.peers.first_call', name]
        runs = {}
        for state in ('cold', 'cached'):
            done = subprocess.run(
                command, env=environment, check=True, capture_output=True, text=True
            )
            runs[state] = json.loads(done.stdout)
    return runs


if __name__ == '__main__':
    print(json.dumps(measure(sys.argv[1])))
