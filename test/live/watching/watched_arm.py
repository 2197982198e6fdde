"""An arm of balls beside a ball that is pushed about, and the truth about it in closed form."""

import math
from types import SimpleNamespace as Plain

import numpy as np
from live.inputs.test_joint_input import ARM, JOINTS_OF_ARM, state
from live.live_scenes import Clock, Topic, live_scene
from live.services.test_motions import poses

from drake_geom_ros.live.inputs.joint_input import JointInput
from drake_geom_ros.live.watching.trajectory_watch import Logs, TrajectoryWatch

RADIUS = 0.1  # [m] of every ball
FAR = (9.0, 9.0, 9.0)
STALE_AFTER = 0.5  # [s]
BEGIN = 1000.0  # [s] the time of the node at first
SCENE = """
sources: [cell]
robots:
- {{name: arm, urdf: {folder}/arm.urdf, pose: {{}}, adjacent_links: filtered}}
frames: [{{name: free, source: cell, pose: {{position: [9, 9, 9]}}}}]
geometries:
- {{name: ball, source: cell, frame: free, shape: {{type: sphere, radius: 0.1}}}}
"""


def distance_to(p_WB, q):
    """Return the distance [m] of the pushed ball from the arm at joint values (3,)."""
    shoulder, wrist, finger = q
    turn = np.array([math.cos(shoulder), math.sin(shoulder), 0.0])
    pitch = 0.3 + wrist
    x_WH = turn * math.cos(pitch) - np.array([0.0, 0.0, math.sin(pitch)])
    hand = turn + np.array([0.0, 0.0, 1.0])
    centres = np.array(
        [
            *((0.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)),  # base, mark, upper
            *(hand, hand + finger * x_WH, hand + (0.01 - 2.0 * finger) * x_WH),
        ]
    )
    return float(np.linalg.norm(centres - np.asarray(p_WB), axis=1).min()) - 2.0 * RADIUS


def stamp_of(seconds):
    """Return a builtin_interfaces/Time."""
    whole, part = divmod(round(1e9 * seconds), 10**9)
    return Plain(sec=whole, nanosec=part)


def joint_trajectory(rows, times, velocities=None, stamp=0.0, names=JOINTS_OF_ARM):
    """Return a JointTrajectory with its start [s] of the node's time, 0: now."""
    points = [
        Plain(
            positions=list(row),
            velocities=[] if velocities is None else list(velocities[k]),
            accelerations=[],
            effort=[],
            time_from_start=stamp_of(times[k]),
        )
        for k, row in enumerate(rows)
    ]
    header = Plain(stamp=stamp_of(stamp), frame_id='')
    return Plain(header=header, joint_names=list(names), points=points)


class Cell:
    """The live scene with a watch, and what a controller, a pusher and a node do in it."""

    def __init__(self, folder):
        (folder / 'arm.urdf').write_text(ARM)
        self.clock = Clock(BEGIN)
        self.live = live_scene(SCENE.format(folder=folder), self.clock)
        self.live.stale_after = STALE_AFTER
        self.joints = JointInput(self.live.clocks, 1.0, by_default=True)
        self.topic, self.infos, self.warnings, self.did = Topic(), [], [], []
        self.watch = TrajectoryWatch(
            self.live,
            self.topic,
            lambda: Plain(header=Plain(stamp=Plain(), frame_id='')),
            Logs(self.infos.append, self.warnings.append),
            lambda pairs, seconds: self.did.append(pairs),
        )

    def stand(self, q, names=JOINTS_OF_ARM, at=None):
        """Have joint values come that hold now, or at a time of the node."""
        with self.live.editing() as scene:
            self.joints.take(scene, state(names, q, self.clock.now if at is None else at), 0.0)

    def push(self, p_WB):
        """Pose the ball."""
        with self.live.editing() as scene:
            message = poses(free=[*p_WB, 0, 0, 0, 1])
            message.header = Plain(frame_id='', stamp=stamp_of(self.clock.now))
            scene.poses.take(message)

    def begin(self, path, name='', **fields):
        """Call watch_trajectory, and return the name."""
        request = {
            'name': name,
            'path': path,
            'min_distance': 0.0,
            'profile': '',
            'deviation_tolerance': 0.0,
            'time_budget': 0.0,
            'accuracy': '',
            'ignore_start_contacts': False,
            'ignore_limits': False,
            'ignore_foreign_joints': False,
        }
        response = Plain(name='')
        self.watch.begin(Plain(**{**request, **fields}), response)
        return response.name

    def end(self, name):
        """Call unwatch_trajectory."""
        self.watch.end(Plain(name=name), Plain())

    def look(self):
        """Have the watch look, and return the last message."""
        self.watch.look()
        return self.topic.published[-1]
