"""What there is, and what sensors see of it: the simulation's side, which knows the truth.

The robot drives to and fro while its arm swings. It hears its commands late and brakes as the rule
`can stop` declares: base and arm go by one share of their nominal speed. A person
walks from place to place and round the robot, and a trolley rolls past it. Lidars and camera see
both and the walls; a tracker names the person while she is within its range.
"""

import math
from collections import deque
from pathlib import Path
from types import SimpleNamespace as Plain

import numpy as np

from drake_geom_ros.geometry.render import DepthCameraProperties
from drake_geom_ros.live.inputs.joint_input import JointInput
from drake_geom_ros.live.inputs.pose_inputs import PoseInputs
from drake_geom_ros.live.scene.changes.addition import addition
from drake_geom_ros.live.scene.changes.attachment import attachment
from drake_geom_ros.live.scene.clocks import Clocks
from drake_geom_ros.live.scene.live_scene import LiveScene
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.scene_files import read_scene
from drake_geom_ros.scene_files.cameras import RENDERERS

HERE = Path(__file__).parent
ROOM = 6.0  # [m] from the middle to each wall
LIDAR_RAYS, LIDAR_VIEW, LIDAR_REACH = 360, 1.5 * math.pi, 12.0
CAMERA = DepthCameraProperties(32, 24, 1.0, RENDERERS['perception'][0], 0.1, 12.0)
TRACKER_RANGE = 5.0  # [m] from the middle
STEP_OF_NONE = 1e-9  # [m]
PASSING = 1.1  # [m] from the middle of the robot: nearer she does not walk
PERSON, TROLLEY = 0.25, 0.3  # [m] radii
WALK, ROLL, DRIVE = 1.2, 0.4, 0.5  # [m/s]
REACTION = 3  # steps from a command to the change of speed
BRAKES = np.array([1.0, 1.0, 1.0, 2.0, 2.0])  # of x, y, theta, shoulder and elbow, as declared
X_HAND_BOX = RigidTransform([0.16, 0.0, 0.0])


class Clock:
    """The time of the simulation [s]."""

    def __init__(self, now=1000.0):
        self.now = now

    def __call__(self):
        """Return the time."""
        return self.now


def header(now, frame=''):
    """Return a std_msgs/Header."""
    whole, part = divmod(round(now * 1e9), 10**9)
    return Plain(stamp=Plain(sec=whole, nanosec=part), frame_id=frame)


class RobotScene:
    """A live scene of the robot, which odometry and two publishers of joints pose."""

    def __init__(self, file, clock):
        self.live = LiveScene('exact', Clocks(clock, clock))
        self.inputs = PoseInputs(joints=JointInput(self.live.clocks, 1.0, by_default=True))
        with self.live.editing() as scene:
            scene.make(addition(read_scene(HERE / file)))

    def pose(self, now, row, arm, grip, speeds=(0.0, 0.0)):
        """Take odometry, the arm's joints with their speeds, and the gripper's."""
        poses = {'source': 'mobile', 'frame_names': ['base_link'], 'frame_ids': []}
        with self.live.editing() as scene:
            message = Plain(header=header(now), **poses, poses=row)
            self.inputs.take_poses(scene, message, 0.0, 'odometry')
            for sender, names, values, rates in (
                ('arm', ['shoulder', 'elbow'], arm, list(speeds)),
                ('gripper', ['grip'], [grip], [0.0]),
            ):
                joints = Plain(
                    header=header(now), name=names, position=values, velocity=rates, effort=[]
                )
                topic = 'joint_states'
                self.inputs.take_joint_states(scene, joints, 0.0, topic, sender)

    def carry(self):
        """Attach the box to the hand, and let the gripper touch it."""
        with self.live.editing() as scene:
            names = scene.model.names
            box, hand = names.frame('box'), names.frame('hand')
            touching = [
                geometry
                for geometry, name in names.geometry_names.items()
                if name.startswith(('mobile::hand/', 'mobile::finger/'))
            ]
            scene.make(attachment(scene, box, hand, X_HAND_BOX, touching=touching))


class World:
    """The truth at a time, which ``step`` moves on."""

    def __init__(self, clock, seed=0):
        self.clock = clock
        self.robot = RobotScene('truth.yaml', clock)
        self._random = np.random.default_rng(seed)
        self._phase, self._way = 0.0, 0.0
        self.person, self._goal = np.array([2.5, 1.0]), np.array([0.3, -0.2])
        self._rolled = 0.0
        self.share = 0.0  # of the nominal speed
        self._commands = deque([0.0] * REACTION)
        self.move(share=0.0, seconds=0.0)
        self.robot.carry()

    def move(self, *, share, seconds):
        """Move all that moves for some time [s]; the robot hears a share of its speed later."""
        self._commands.append(share)
        heard, before = self._commands.popleft(), self.share
        whole = max(np.abs([*self.command[[0, 1, 5]], *self.arm_rates]) / BRAKES)
        most = seconds / max(whole, STEP_OF_NONE)
        self.share += float(np.clip(heard - before, -most, most))
        gone = 0.5 * (before + self.share) * seconds
        self._phase += gone
        self._way += DRIVE * gone
        self._rolled += ROLL * seconds
        step = self._goal - self.person
        left = float(np.linalg.norm(step))
        there = self.person + step / max(left, STEP_OF_NONE) * min(left, WALK * seconds)
        if left <= WALK * seconds or np.linalg.norm(there - self.base[:2]) < PASSING:
            self._goal = self._random.uniform(-5.0, 5.0, 2)
        else:
            self.person = there
        self._pose()

    @property
    def base(self):
        """The pose of the base: x, y [m] and heading [rad]."""
        return 2.0 * math.sin(0.5 * self._way), -1.0, 0.3 * math.sin(0.4 * self._way)

    @property
    def arm(self):
        """The joints of the arm and of the gripper [rad], [m]."""
        return [1.2 * math.sin(0.7 * self._phase), 0.4 * math.sin(0.5 * self._phase)], 0.02

    @property
    def arm_rates(self):
        """The nominal speeds of the arm's joints [rad/s]."""
        return [0.84 * math.cos(0.7 * self._phase), 0.2 * math.cos(0.5 * self._phase)]

    @property
    def command(self):
        """The nominal twist of the base in its own axes: linear [m/s] and angular [rad/s] (6,)."""
        forward, yaw = DRIVE * math.cos(0.5 * self._way), self.base[2]
        turn = 0.12 * DRIVE * math.cos(0.4 * self._way)
        return np.array([forward * math.cos(yaw), -forward * math.sin(yaw), 0.0, 0.0, 0.0, turn])

    @property
    def trolley(self):
        """The place of the trolley [m]."""
        return np.array([3.0 * math.cos(0.3 * self._rolled), 1.7 - 1.5 * math.sin(self._rolled)])

    @property
    def row(self):
        """X_WB of the base as a row of seven."""
        x, y, yaw = self.base
        return [x, y, 0.0, 0.0, 0.0, math.sin(0.5 * yaw), math.cos(0.5 * yaw)]

    def _pose(self):
        self.robot.pose(self.clock.now, self.row, *self.arm)
        bodies = {'person': (*self.person, 0.9), 'trolley': (*self.trolley, 0.5)}
        rows = [value for p in bodies.values() for value in (*p, 0.0, 0.0, 0.0, 1.0)]
        message = Plain(
            header=header(self.clock.now),
            source='world',
            frame_names=list(bodies),
            frame_ids=[],
            poses=rows,
        )
        with self.robot.live.editing() as scene:
            self.robot.inputs.take_poses(scene, message)

    def distances(self):
        """Return the true distance [m] of the robot, with what it carries, to each body."""
        with self.robot.live.reading() as scene:
            pairs = scene.query.ComputeSignedDistancePairwiseClosestPoints(3.0)
            names = {g.get_value(): n for g, n in scene.model.names.geometry_names.items()}
        nearest = {'person': 3.0, 'trolley': 3.0}
        for a, b, distance in zip(pairs.id_A, pairs.id_B, pairs.distance, strict=True):
            both = names[int(a)], names[int(b)]
            for body in nearest:
                others = [n for n in both if not n.startswith('world::')]
                if f'world::{body}/body' in both and len(others) == 1:
                    nearest[body] = min(nearest[body], float(distance))
        return nearest

    def scan(self, frame):
        """Return what a lidar measures now (LaserScan)."""
        with self.robot.live.reading() as scene:
            X_WL = scene.query.X_WF(scene.model.names.frame(f'mobile::{frame}'))
        angles = np.linspace(-0.5, 0.5, LIDAR_RAYS) * LIDAR_VIEW
        rays = X_WL.rotation().matrix() @ [np.cos(angles), np.sin(angles), 0.0 * angles]
        ranges = _ranges(X_WL.translation()[:2], rays[:2].T, [
            (self.person, PERSON), (self.trolley, TROLLEY),
        ])  # fmt: skip
        return Plain(
            header=header(self.clock.now, f'mobile::{frame}'),
            ranges=ranges, range_min=0.05, range_max=LIDAR_REACH, angle_min=float(angles[0]),
            angle_max=float(angles[-1]), angle_increment=float(angles[1] - angles[0]),
            time_increment=0.0, scan_time=0.0, intensities=[],
        )  # fmt: skip

    def depth(self, robot=None):
        """Return what the camera sees now, by the exact image engine: Image and CameraInfo.

        With a ``robot`` of another scene it sees what that scene has.
        """
        with (robot or self.robot).live.reading() as scene:
            names, query = scene.model.names, scene.query
            image = query.RenderDepthImage(CAMERA, names.frame('mobile::camera'), RigidTransform())
        depths = np.array(image.data, dtype='<f4').reshape(CAMERA.height, CAMERA.width)
        stamp = header(self.clock.now, 'mobile::camera')
        focal = 0.5 * CAMERA.height / math.tan(0.5 * CAMERA.fov_y)
        middle = 0.5 * (CAMERA.width - 1), 0.5 * (CAMERA.height - 1)
        K = [focal, 0.0, middle[0], 0.0, focal, middle[1], 0.0, 0.0, 1.0]
        P = [*K[:3], 0.0, *K[3:6], 0.0, *K[6:], 0.0]
        sizes = {'width': CAMERA.width, 'height': CAMERA.height}
        roi = Plain(x_offset=0, y_offset=0, width=0, height=0)
        info = Plain(header=stamp, **sizes, k=K, p=P, d=[], roi=roi, binning_x=0, binning_y=0)
        picture = Plain(
            header=stamp, **sizes, encoding='32FC1', is_bigendian=False, step=4 * CAMERA.width,
            data=bytearray(depths.tobytes()),
        )  # fmt: skip
        return picture, info

    def seen_by_tracker(self):
        """Return the name and the place of the person, if the tracker sees her."""
        if np.linalg.norm(self.person) > TRACKER_RANGE:
            return {}
        return {'person': (*self.person, 0.9)}


def _ranges(origin, rays, circles):
    """Return the distances (n,) [m] along rays (n, 2) to the nearest of walls and circles."""
    with np.errstate(divide='ignore'):
        to_walls = np.where(rays > 0.0, ROOM - origin, -ROOM - origin) / rays
    ranges = to_walls.min(axis=1)
    for centre, radius in circles:
        toward = centre - origin
        along = rays @ toward
        aside = toward @ toward - along**2
        hits = (along > 0.0) & (aside < radius**2)
        reach = along - np.sqrt(np.where(hits, radius**2 - aside, 0.0))
        ranges = np.where(hits, np.minimum(ranges, reach), ranges)
    return ranges
