"""Seconds from `pip install` to the first answers, of the wheels in a folder.

    ./run wheels 3.11
    ./run exec python -m bench.costs.first_answer [--dist dist] [--distribution kilted] [--runs 3]

Each run makes an empty environment, installs by pip with pip's cache as it is, and starts programs
with a PATH that has that environment alone: no compiler and nothing sourced. The node is active
when its scene is published. Wall-clock seconds; the first start of each program writes Python's
bytecode.
"""

from __future__ import annotations

import argparse
import os
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Mapping
from pathlib import Path

from drake_geom_ros.common.children import end

ROOT = Path(__file__).parents[2]
SCENE = ROOT / 'scenes/minimal.yaml'
# Says when it listens, then when the node's scene came.
LISTENING = """
from drake_geom_ros.client import SceneGraphClient
with SceneGraphClient(patience=600.0) as client:
    print('listening', flush=True)
    client.scene()
    print('active', flush=True)
"""


def seconds_of(command: list[object], environment: Mapping[str, str], folder: Path) -> float:
    """Return the seconds that a command takes; SystemExit where it fails."""
    start = time.perf_counter()
    done = subprocess.run(
        list(map(str, command)), env=environment, cwd=folder, capture_output=True, text=True
    )
    if done.returncode:
        raise SystemExit(f'{command[0]} ended with {done.returncode}:\n{done.stderr[-2000:]}')
    return time.perf_counter() - start


def seconds_to_active(programs: Path, environment: Mapping[str, str], folder: Path) -> float:
    """Return the seconds from the start of a node to its being active."""
    listener = subprocess.Popen(
        [programs / 'python', '-c', LISTENING],
        env=environment,
        stdout=subprocess.PIPE,
        text=True,
    )
    assert listener.stdout is not None
    assert listener.stdout.readline() == 'listening\n'
    start = time.perf_counter()
    node = subprocess.Popen(
        [programs / 'drake_geom_ros', 'node', SCENE],
        env=environment,
        cwd=folder,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    try:
        assert listener.stdout.readline() == 'active\n'
        return time.perf_counter() - start
    finally:
        end(listener, 10.0)
        end(node, 60.0)


def one_run(options: argparse.Namespace, folder: Path) -> dict[str, float]:
    """Return the seconds of each step in a new environment below a folder."""
    programs = folder / 'venv/bin'
    kept = ('PIP_', 'UV_', 'HTTP', 'http', 'HOME')
    installing = {k: v for k, v in os.environ.items() if k.startswith(kept)}
    installing |= {'PATH': str(programs), 'PIP_DISABLE_PIP_VERSION_CHECK': '1'}
    alone = {
        'PATH': str(programs),
        'HOME': str(folder),
        'DRAKE_GEOM_ROS_COMPILE': 'never',
        'ROS_AUTOMATIC_DISCOVERY_RANGE': 'LOCALHOST',
        'ROS_DOMAIN_ID': os.environ.get('ROS_DOMAIN_ID', '0'),
    }
    seconds_of([sys.executable, '-m', 'venv', folder / 'venv'], os.environ, folder)
    package = f'drake_geom_ros[{options.distribution}]'
    pip = [programs / 'python', '-m', 'pip', 'install', '--find-links', options.dist.resolve()]
    query = [programs / 'drake_geom_ros', 'query', SCENE]
    return {
        'pip install': seconds_of([*pip, package], installing, folder),
        'first query': seconds_of(query, alone, folder),
        'next query': seconds_of(query, alone, folder),
        'node active, first start': seconds_to_active(programs, alone, folder),
        'node active, next start': seconds_to_active(programs, alone, folder),
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('--dist', type=Path, default=ROOT / 'dist', help='folder of the wheels')
    parser.add_argument('--distribution', choices=('kilted', 'jazzy'), default='kilted')
    parser.add_argument('--runs', type=int, default=3)
    options = parser.parse_args()
    runs = []
    for _ in range(options.runs):
        with tempfile.TemporaryDirectory() as folder:
            runs.append(one_run(options, Path(folder)))
    print(f'| step | seconds, median of {options.runs} | from | to |')
    print('|---|---|---|---|')
    for step in runs[0]:
        each = [run[step] for run in runs]
        print(f'| {step} | {statistics.median(each):.1f} | {min(each):.1f} | {max(each):.1f} |')


if __name__ == '__main__':
    main()
