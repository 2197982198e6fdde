"""From an hour's recording to a clearance report: time, memory, and a pydrake loop beside it.

    ./run exec python -m bench.batches.recorded_hour [--minutes 60] [--part 2000]

Two arms swing smoothly at 100 Hz, and their joint states are recorded by the writer of rosbags as
an MCAP. The command ``report`` takes them with the demo's scene, from the recording to the
finished folder, in a process of its own: its wall clock, processor time and peak memory are told,
and of these what reading and computing took. Then pydrake poses its plant of the same arms at the
first states and looks for their least distances, in a loop; ours is asked the same question, pairs
of the two arms, from a recording of this part. Ratios of one run can be compared.
"""

from __future__ import annotations

import argparse
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

from bench.batches.drake_side import DrakeSide
from bench.batches.ours import ROOT, Ours
from drake_geom_ros.recordings import clearance

RATE = 100.0  # [Hz]
SLOW, FAST = 0.05, 0.4  # [Hz] of the swing of joints
BEGIN = 1_700_000_000 * 10**9  # [ns]
ARMS = 'left:right'

Floats = NDArray[np.float64]


def swing(ours: Ours, count: int) -> Floats:
    """Return joint values (count, 16) that go to and fro within the limits, each as it likes."""
    rng = np.random.default_rng(0)
    lower, upper = ours.joints.lower, ours.joints.upper
    frequencies = rng.uniform(SLOW, FAST, len(lower))
    phases = rng.uniform(0.0, 2.0 * np.pi, len(lower))
    turns = np.sin(2.0 * np.pi * frequencies * (np.arange(count) / RATE)[:, np.newaxis] + phases)
    return np.asarray(0.5 * (lower + upper) + 0.3 * (upper - lower) * turns, dtype=np.float64)


def record(folder: Path, names: list[str], states: Floats) -> Path:
    """Record joint states (n, j), one each hundredth of a second; return the folder."""
    store = get_typestore(Stores.ROS2_JAZZY)
    stamp, header, joints = (
        store.types[name]
        for name in (
            'builtin_interfaces/msg/Time',
            'std_msgs/msg/Header',
            'sensor_msgs/msg/JointState',
        )
    )
    none = np.zeros(0)
    with Writer(folder, version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        topic = writer.add_connection('/joint_states', joints.__msgtype__, typestore=store)
        for k, row in enumerate(states):
            at = BEGIN + round(1e9 * k / RATE)
            message = joints(header(stamp(*divmod(at, 10**9)), ''), names, row, none, none)
            writer.write(topic, at, store.serialize_cdr(message, joints.__msgtype__))
    return folder


def report(run: Path, scene: Path, out: Path) -> None:
    """Have the report made, and print what it took."""
    command = [sys.executable, '-m', 'drake_geom_ros', 'report', str(run), '--scene', str(scene)]
    start, most = time.perf_counter(), 0.0
    with subprocess.Popen([*command, '--out', str(out)], cwd=ROOT) as process:
        while process.poll() is None:
            most = max(most, peak_memory(process.pid))
            time.sleep(0.05)
    wall, used = time.perf_counter() - start, resource.getrusage(resource.RUSAGE_CHILDREN)
    print(
        f'report (exit code {process.returncode}): {wall:.1f} s, '
        f'{used.ru_utime + used.ru_stime:.1f} s of the processor, at most {most:.0f} MB'
    )


def peak_memory(pid: int) -> float:
    """Return the most memory [MB] that a process had so far; 0 where it has ended.

    ``ru_maxrss`` of a child counts what its parent had when it was forked, too.
    """
    try:
        status = Path(f'/proc/{pid}/status').read_text()
    except OSError:
        return 0.0
    peaks = [line.split()[1] for line in status.splitlines() if line.startswith('VmHWM')]
    return int(peaks[0]) * 1024 / 1e6 if peaks else 0.0


def beside_pydrake(ours: Ours, states: Floats, run: Path, scene: Path) -> None:
    """Print how long both take for the least distance of the arms at each state."""
    robots = {'left', 'right'}
    between = {pair for pair in ours.pairs() if {source for source, _, _ in pair} == robots}
    drake = DrakeSide(ours)
    common = between & drake.pairs()
    assert common == between, 'pydrake has all pairs of the two arms'
    drake.keep_only(common)
    drake.least(states[:100])
    start = time.perf_counter()
    truth = drake.least(states)
    theirs = time.perf_counter() - start
    found = clearance(run, scene, between=[ARMS])
    own = found.seconds_reading + found.seconds_computing
    off = np.abs(found[ARMS].known_distance - truth).max()
    by_state = 1e6 / len(states)
    print(
        f'{len(states)} states, {len(common)} pairs: pydrake {theirs * by_state:.0f} us a state, '
        f'ours {own * by_state:.0f} with reading, {theirs / own:.1f} times as fast; '
        f'they differ by at most {off:.1g} m'
    )


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.split('\n')[0])
    parser.add_argument('--minutes', type=float, default=60.0, help='of the recording')
    parser.add_argument(
        '--part', type=int, default=2000, help='states that pydrake is asked about'
    )
    options = parser.parse_args()
    ours = Ours()
    names = list(ours.joints.names)
    states = swing(ours, round(60.0 * options.minutes * RATE))
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder)
        scene = path / 'cell.yaml'
        scene.write_text(ours.text)
        run = record(path / 'hour', names, states)
        print(f'{len(states)} joint states of {len(names)} joints recorded')
        report(run, scene, path / 'report')
        part = states[: options.part]
        beside_pydrake(ours, part, record(path / 'part', names, part), scene)


if __name__ == '__main__':
    main()
