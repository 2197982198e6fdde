"""Reading a recording whose poses come by TF: many messages at once, and one by one, in turns.

A state publisher's messages: the transforms of all links of two swinging arms at 100 Hz, recorded
by the writer of rosbags as an MCAP. Played are its states alone, without distances, by the player
that ``report`` has; and by the same one where no run is ever long enough to be one. Ratios of one
run can be compared.

    ./run exec python -m bench.batches.recorded_tf [--messages 3000] [--turns 3]
"""

from __future__ import annotations

import argparse
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

from bench.batches.ours import Ours
from bench.batches.recorded_hour import ARMS, BEGIN, RATE, Floats, swing
from drake_geom_ros.recordings import player
from drake_geom_ros.recordings.opened import opened_recording
from drake_geom_ros.recordings.pair_sets import pair_sets
from drake_geom_ros.recordings.states import StateBlocks
from drake_geom_ros.scene_files import read_scene
from drake_geom_ros.trajectories import Kinematics
from drake_geom_ros.trajectories.pose_matrices import inverse, poses_of_matrices

NEVER = 10**9  # messages of a run


class Sender:
    """Makes the messages of a state publisher for the robots of a scene file."""

    def __init__(self, scene: Path) -> None:
        self._types = get_typestore(Stores.ROS2_JAZZY).types
        robots = read_scene(str(scene)).robots
        self._robots = [(r, Kinematics(r.tree)) for r in robots if r.tree is not None]

    def bases(self) -> Any:
        """Return the static transforms of the robots' bases."""
        names = [(f'{r.name}/{arm.link_names[0]}', r) for r, arm in self._robots]
        return self._message([('world', name, r.X_WB.ToArray()) for name, r in names], 0)

    def links(self, values: dict[str, float], at: int) -> Any:
        """Return the transform of each link in its parent link, at a time [ns]."""
        found = []
        for robot, arm in self._robots:
            q = np.array([values[f'{robot.name}::{joint}'] for joint in arm.joint_names])
            X_BLs = arm.link_transforms(q)
            rows = {link: row for row, link in enumerate(arm.link_names)}
            parents, children = np.array([[rows[end] for end in j] for j in arm.joined_links]).T
            poses = poses_of_matrices(inverse(X_BLs[parents]) @ X_BLs[children])
            for (parent, child), X in zip(arm.joined_links, poses, strict=True):
                found.append((f'{robot.name}/{parent}', f'{robot.name}/{child}', X))
        return self._message(found, at)

    def _message(self, edges: list[tuple[str, str, Floats]], at: int) -> Any:
        def made(name: str, *fields: Any) -> Any:
            return self._types[name](*fields)

        stamp = made('builtin_interfaces/msg/Time', *divmod(at, 10**9))
        entries = []
        for parent, child, X in edges:
            p = made('geometry_msgs/msg/Vector3', *X[:3].tolist())
            q = made('geometry_msgs/msg/Quaternion', *X[3:].tolist())
            transform = made('geometry_msgs/msg/Transform', p, q)
            header = made('std_msgs/msg/Header', stamp, parent)
            entries.append(made('geometry_msgs/msg/TransformStamped', header, child, transform))
        return made('tf2_msgs/msg/TFMessage', entries)


def record(folder: Path, sender: Sender, names: list[str], states: Floats) -> int:
    """Record joint states (n, j) as TF; return how many transforms a message holds."""
    store = get_typestore(Stores.ROS2_JAZZY)
    kind, count = 'tf2_msgs/msg/TFMessage', 0
    with Writer(folder, version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        still = writer.add_connection('/tf_static', kind, typestore=store)
        moving = writer.add_connection('/tf', kind, typestore=store)
        writer.write(still, BEGIN, store.serialize_cdr(sender.bases(), kind))
        for k, row in enumerate(states):
            at = BEGIN + round(1e9 * (k + 1) / RATE)
            message = sender.links(dict(zip(names, row.tolist(), strict=True)), at)
            count = len(message.transforms)
            writer.write(moving, at, store.serialize_cdr(message, kind))
    return count


def play(run: Path, scene: Path) -> float:
    """Play a recording; return the seconds that it took."""
    opened = opened_recording(
        run,
        scene=scene,
        topics=None,
        stale_after=1.0,
        accuracy='exact',
        world_frame='world',
        package_roots=(),
    )
    played = player.Player(opened, StateBlocks(opened.playback, pair_sets([ARMS])), 0.0)
    start = time.perf_counter()
    states = sum(len(block.times) for block in played.blocks())
    seconds = time.perf_counter() - start
    assert states > 0, 'the recording poses nothing'
    return seconds


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.split('\n')[0])
    parser.add_argument('--messages', type=int, default=3000)
    parser.add_argument('--turns', type=int, default=3)
    options = parser.parse_args()
    ours, usual = Ours(), player._SHORTEST
    found: dict[str, list[float]] = {'many at once': [], 'one by one': []}
    with tempfile.TemporaryDirectory() as folder:
        scene, run = Path(folder) / 'cell.yaml', Path(folder) / 'run'
        scene.write_text(ours.text)
        states = swing(ours, options.messages)
        count = record(run, Sender(scene), list(ours.joints.names), states)
        print(f'{options.messages} messages of {count} transforms')
        for _ in range(options.turns):
            for way, shortest in zip(found, (usual, NEVER), strict=True):
                player._SHORTEST = shortest
                found[way].append(1e3 * play(run, scene) / options.messages)
    for way, times in found.items():
        told = ', '.join(f'{each:.3f}' for each in times)
        print(f'{way:>13}: {told} ms a message')
    ratio = np.median(found['one by one']) / np.median(found['many at once'])
    print(f'{ratio:.1f} times as fast')


if __name__ == '__main__':
    main()
