"""Seconds of the first command in a bare clone of this repository.

    ./run exec python -m bench.costs.bare_clone [--seconds 5] [--cached] [--runs 1]

Clones what is committed here into an empty folder, and runs ``./run demo`` there, without this
environment. Packages are downloaded anew, unless ``--cached`` lets uv and pip use what they have.
Wall-clock and processor seconds of the whole, and when the first picture was there; the motion
takes ``--seconds`` of it. The kernels that only other scenes need are compiled beside it, and are
ended with it.
"""

from __future__ import annotations

import argparse
import contextlib
import os
import resource
import signal
import subprocess
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).parents[2]
# What a shell of this environment has set, and a terminal has not.
OF_THIS_ENVIRONMENT = (
    *('AMENT_', 'CMAKE_', 'COLCON_', 'DRAKE_GEOM_ROS_', 'FASTDDS_', 'FASTRTPS_', 'NUMBA_'),
    *('PYTHON', 'RMW_', 'ROS_', 'VIRTUAL_ENV', '_ROS_', 'LD_LIBRARY_PATH'),
)


def bare_environment(folder: Path, cached: bool) -> dict[str, str]:
    """Return the variables of a terminal; without ``cached`` empty caches of packages."""
    here = (str(ROOT), os.environ.get('VIRTUAL_ENV', str(ROOT)))
    kept = {k: v for k, v in os.environ.items() if not k.startswith(OF_THIS_ENVIRONMENT)}
    paths = os.environ['PATH'].split(os.pathsep)
    kept['PATH'] = os.pathsep.join(path for path in paths if not path.startswith(here))
    if not cached:
        kept |= {'UV_CACHE_DIR': str(folder / 'uv'), 'PIP_CACHE_DIR': str(folder / 'pip')}
    return kept


def one_run(seconds: float, cached: bool) -> tuple[float, float, float]:
    """Return the seconds of a run: until its first picture, of the whole, of processors."""
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as name:
        clone = Path(name) / 'clone'
        subprocess.run(['git', 'clone', '-q', str(ROOT), str(clone)], check=True)
        before, start = resource.getrusage(resource.RUSAGE_CHILDREN), time.time()
        demo = ['./run', 'demo', '--seconds', str(seconds)]
        environment = bare_environment(Path(name), cached)
        process = subprocess.Popen(demo, cwd=clone, env=environment, start_new_session=True)
        code = process.wait()
        whole, after = time.time() - start, resource.getrusage(resource.RUSAGE_CHILDREN)
        with contextlib.suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGTERM)  # those for other scenes
        if code:
            raise SystemExit(f'./run demo ended with {code}')
        first = min(path.stat().st_mtime for path in (clone / 'out/demo').rglob('*.png')) - start
    used = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return first, whole, used


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('--seconds', type=float, default=5.0, help='of the motion')
    parser.add_argument('--cached', action='store_true', help='packages were downloaded before')
    parser.add_argument('--runs', type=int, default=1)
    options = parser.parse_args()
    print('| the first picture [s] | the whole [s] | processor time [s] |')
    print('|---|---|---|')
    for _ in range(options.runs):
        print(
            '| ' + ' | '.join(f'{s:.0f}' for s in one_run(options.seconds, options.cached)) + ' |'
        )


if __name__ == '__main__':
    main()
