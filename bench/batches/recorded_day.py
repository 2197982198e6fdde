"""Whether the memory of a clearance report grows with the length of the recording.

    ./run exec python -m bench.batches.recorded_day [--hours 2.4] [--times 10]

A ball swings beside a box at 100 Hz; the writer of rosbags records its poses as an MCAP. The
command ``report`` is run on a recording, and on one that is so many times as long, each in a
process of its own: its wall clock, processor time and peak memory are told.
"""

from __future__ import annotations

import argparse
import tempfile
from pathlib import Path

import numpy as np
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from bench.batches.recorded_hour import BEGIN, RATE, report
from drake_geom_ros.recordings.message_types import FRAME_POSES, POSES

SCENE = """
sources: [s]
frames: [{name: a, source: s}]
geometries:
- {name: ball, source: s, frame: a, shape: {type: sphere, radius: 0.1}}
- {name: box, source: s, shape: {type: box, size: [0.2, 0.2, 0.2]}}
"""


def record(folder: Path, count: int) -> Path:
    """Record poses, one each hundredth of a second; return the folder."""
    store = get_typestore(Stores.ROS2_JAZZY)
    store.register(get_types_from_msg(FRAME_POSES, POSES))
    poses, header, time = (
        store.types[name] for name in (POSES, 'std_msgs/msg/Header', 'builtin_interfaces/msg/Time')
    )
    row = np.array([0.0, 0, 0, 0, 0, 0, 1])
    ids = np.zeros(0, dtype=np.uint64)
    with Writer(folder, version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        topic = writer.add_connection('/frame_poses', POSES, typestore=store)
        for k in range(count):
            at = BEGIN + round(1e9 * k / RATE)
            row[0] = 0.6 + 0.35 * np.cos(0.001 * k)
            message = poses(header(time(*divmod(at, 10**9)), ''), '', ['s::a'], ids, row)
            writer.write(topic, at, store.serialize_cdr(message, POSES))
    return folder


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.split('\n')[0])
    parser.add_argument('--hours', type=float, default=2.4, help='of the shorter recording')
    parser.add_argument('--times', type=int, default=10, help='how much longer the other one is')
    options = parser.parse_args()
    count = round(3600.0 * options.hours * RATE)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder)
        scene = path / 'scene.yaml'
        scene.write_text(SCENE)
        for states in (count, options.times * count):
            run = record(path / f'of_{states}', states)
            print(f'{states / RATE / 3600.0:g} hours, {states} states:')
            report(run, scene, path / f'report_{states}')


if __name__ == '__main__':
    main()
