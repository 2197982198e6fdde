"""What each scene of a ladder calls for, measured and written to docs/effects.md.

    python -m bench.effects [--runs 3] [--quick] [--out docs/effects.md]

Each rung runs in new processes: once with an empty cache of kernels, which fills up along the
ladder, and some times with the full one. Then the real node runs some of them, where ROS is.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
from importlib import metadata
from pathlib import Path
from typing import Any

from bench.effects import report
from bench.effects.rungs import LADDER
from bench.pages import processor
from bench.peers.run import machine

ROOT = Path(__file__).resolve().parents[2]
WARMING = 0.5  # [s] of poses to a node of each rung that is not timed


def in_process(folder: Path, cache: Path) -> dict[str, Any]:
    """Measure a rung in a process of its own."""
    path = os.pathsep.join(entry for entry in (str(ROOT), os.environ.get('PYTHONPATH')) if entry)
    done = subprocess.run(
        [sys.executable, '-m', 'bench.effects.core', str(folder)],
        env={**os.environ, 'NUMBA_CACHE_DIR': str(cache), 'PYTHONPATH': path},
        check=True,
        stdout=subprocess.PIPE,
        text=True,
    )
    result: dict[str, Any] = json.loads(done.stdout)
    return result


def others(modules: list[str]) -> set[str]:
    """Return the names of the packages of others that top-level modules belong to."""
    ours = {'drake_geom_ros', 'drake_geom_msgs'}
    known = metadata.packages_distributions()
    foreign = (m for m in modules if m not in ours and m not in sys.stdlib_module_names)
    return {known[module][0] for module in foreign if module in known}


def climb(folders: dict[str, Path], cache: Path, runs: int, cold: bool) -> tuple[Any, Any]:
    """Return the cold result and the warm results of each rung.

    The warm ones take turns, so that whatever else the machine does slows all rungs alike.
    """
    colds, warm = {}, {name: [] for name in folders}
    for name, folder in folders.items():
        start = time.perf_counter()
        first = in_process(folder, cache)
        if cold:
            colds[name] = first
        print(f'{name}: {time.perf_counter() - start:.0f} s', flush=True)
    for turn in range(runs):
        for name, folder in folders.items():
            warm[name].append(in_process(folder, cache))
        print(f'turn {turn + 1} of {runs} with a full cache: done', flush=True)
    return colds, warm


def ask_node(folders: dict[str, Path], seconds: float) -> str:
    """Return the section about the real node, or why it is left out."""
    os.environ.setdefault('ROS_AUTOMATIC_DISCOVERY_RANGE', 'LOCALHOST')
    os.environ.setdefault('ROS_DOMAIN_ID', str(1 + os.getpid() % 100))
    try:
        from bench.effects.node import CASES, measure
    except ImportError as error:
        return report.NO_ROS.format(reason=error)
    for case in {case.rung: case for case in CASES}.values():
        measure(case, folders[case.rung], WARMING)  # compiles what only a node runs, as images
    told = []
    for case in CASES:
        told.append((case, measure(case, folders[case.rung], seconds)))
        print(f'{case.rung}, {case.says}: done', flush=True)
    heading = report.PUBLISHED.format(rate=report.RATE, seconds=seconds)
    return f'{heading}\n{report.published(told)}'


def main() -> None:
    """Measure and write."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('--runs', type=int, default=3, help='of each rung with a warm cache')
    parser.add_argument('--seconds', type=float, default=2.0, help='of poses to the node')
    parser.add_argument('--quick', action='store_true', help='keep the cache of kernels, one run')
    parser.add_argument('--out', type=Path, default=ROOT / 'docs/effects.md')
    options = parser.parse_args()
    runs = 1 if options.quick else options.runs
    with tempfile.TemporaryDirectory(prefix='effects-') as name:
        folder = Path(name)
        folders = {rung.name: folder / rung.name.replace(' ', '_') for rung in LADDER}
        for rung in LADDER:
            folders[rung.name].mkdir()
            rung.write(folders[rung.name])
        cache = folder / 'cache'
        if options.quick and 'NUMBA_CACHE_DIR' in os.environ:
            cache = Path(os.environ['NUMBA_CACHE_DIR'])
        os.environ['NUMBA_CACHE_DIR'] = str(cache)
        cold, warm = climb(folders, cache, runs, cold=not options.quick)
        node = ask_node(folders, options.seconds)
    scenes = report.scenes(LADDER)
    sections = (
        f'{report.INTRODUCTION}\n{processor()}; {machine()}.\n\n{scenes}',
        f'{report.IMPORTED}\n{report.imported(LADDER, warm, others)}',
        f'{report.COMPILED}\n{report.compiled(LADDER, cold, warm)}',
        f'{report.STARTED}\n{report.started(LADDER, warm)}',
        f'{report.COMPUTED}\n{report.computed(LADDER, warm)}',
        f'{report.ALLOCATED}\n{report.allocated(LADDER, warm)}',
        node,
    )
    options.out.write_text('\n'.join(sections))
    print(f'written: {options.out}')


if __name__ == '__main__':
    main()
