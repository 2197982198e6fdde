"""The table of topics: name, type, QoS profile, and for inputs the thread and the handler.

A topic is a row: the node opens it, and ``policy`` allows it; what publishes on an output stands
in ``live/outputs``. Topics of cameras, of sensors of maps and of single robots, whose names depend
on parameters, are opened by ``outputs/cameras``, ``obstacle_listening``, ``joint_listening`` and
``tracked_listening``.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass
from functools import partial
from typing import Any, NamedTuple

from diagnostic_msgs.msg import DiagnosticArray
from drake_geom_msgs import msg
from rclpy.duration import Duration
from rclpy.publisher import Publisher
from rclpy.qos import DurabilityPolicy, LivelinessPolicy, QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import JointState, PointCloud2
from std_msgs.msg import Float64, String
from visualization_msgs.msg import MarkerArray

from drake_geom_ros.live.conversions.arrivals import MessageInfo, publisher_of, waited
from drake_geom_ros.live.guard import Guard
from drake_geom_ros.live.inputs.planning_scene import PlanningSceneInput
from drake_geom_ros.live.inputs.point_queries import PointQueries
from drake_geom_ros.live.inputs.robot_description import RobotInput
from drake_geom_ros.live.pose_stream import PoseStream
from drake_geom_ros.ros.callback_groups import CallbackGroups
from drake_geom_ros.ros.message_classes import message_class
from drake_geom_ros.ros.message_reading import MessageReader, pose_reader
from drake_geom_ros.ros.parameters import NodeParameters
from drake_geom_ros.ros.surface import (
    Surface,
    latched,
    results,
    sensor_data,
    transforms,
)

# Offered lease; a listener may ask for as much or for longer. A machine that others load may
# keep a thread of the node waiting for some tenths of a second.
DEADLINE = 0.5  # [s] between two values of ~/speed_scale
LEASE = 1.0  # [s] after which a node without a sign of life counts as dead
_MOST_EVENTS = 1000  # messages, each of one cycle, that are kept for slow subscribers


@dataclass(frozen=True)
class Output:
    """A topic that the node publishes; ``kind`` and ``is_open`` are as those of ``Input``."""

    kind: Any
    profile: Callable[[], QoSProfile] = results
    is_open: Callable[[NodeParameters], bool] = lambda _: True

    def type(self) -> Any:
        """Return the class of messages; raises ImportError where its package is missing."""
        return message_class(self.kind) if isinstance(self.kind, str) else self.kind


class Receivers(NamedTuple):
    """The objects that take messages."""

    stream: PoseStream
    points: PointQueries
    robot: RobotInput
    planning: PlanningSceneInput
    log: Callable[[str], object]

    def log_done(self, done: str) -> None:
        """Log what was done, in words; empty where nothing was."""
        if done:
            self.log(done)


class MessageArrival(NamedTuple):
    """Time [s] that a message waited for its callback, and its publisher."""

    waited: float
    sender: str


Handler = Callable[[Receivers, Any, MessageArrival], object]


@dataclass(frozen=True)
class Input:
    """A topic that the node subscribes to.

    ``topic`` may hold names of parameters in braces; where they are empty it is not opened.
    ``kind`` may be text (``package/msg/Type``) for a package that not every installation has.
    ``group`` is a field of ``CallbackGroups``. Without a handler another file opens the topic.
    Messages are read ``by_bytes`` where rclpy takes longer: see ``message_reading``.
    """

    topic: str
    kind: Any
    profile: Callable[[], QoSProfile]
    group: str
    handler: Handler | None = None
    is_open: Callable[[NodeParameters], bool] = lambda _: True
    by_bytes: bool = False

    def type(self) -> Any:
        """Return the class of messages; raises ImportError where its package is missing."""
        return message_class(self.kind) if isinstance(self.kind, str) else self.kind


def _alive(profile: QoSProfile) -> QoSProfile:
    """Add a lease, by which a listener notices a dead node."""
    profile.liveliness = LivelinessPolicy.AUTOMATIC
    profile.liveliness_lease_duration = Duration(seconds=LEASE)
    return profile


def _events() -> QoSProfile:
    return _alive(QoSProfile(depth=_MOST_EVENTS))


def _states() -> QoSProfile:
    return _alive(QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL))


def _speed_scale() -> QoSProfile:
    return _alive(QoSProfile(depth=1, deadline=Duration(seconds=DEADLINE)))


def _changes() -> QoSProfile:
    """Return the profile of changes of a planning scene, none of which may be lost."""
    return QoSProfile(depth=_MOST_EVENTS)


def newest() -> QoSProfile:
    """Return the profile of sensors: an old measurement is not worth its time."""
    return QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)


def _uses_planning_scene(values: NodeParameters) -> bool:
    return values.use_planning_scene


PLANNING_SCENE = '~/planning_scene'
OUTPUTS: Mapping[str, Output] = {
    '~/penetrations': Output(msg.PenetrationPairs),
    '~/signed_distances': Output(msg.SignedDistancePairs),
    '~/cycle_report': Output(msg.CycleReport),
    '~/contact_surfaces': Output(msg.ContactSurfaces),
    '~/point_distances': Output(msg.PointDistances),
    '~/proximity_events': Output(msg.ProximityEvents, _events),
    '~/proximity_states': Output(msg.ProximityStates, _states),
    '~/speed_scale': Output(Float64, _speed_scale),
    '~/trajectory_states': Output(msg.TrajectoryStates, _states),
    '~/speed_limit': Output(msg.SpeedLimits, _speed_scale),
    '~/stopping': Output(msg.Stopping, _speed_scale),
    '~/scene': Output(msg.Scene, latched),
    PLANNING_SCENE: Output('moveit_msgs/msg/PlanningScene', latched, _uses_planning_scene),
    '~/markers': Output(MarkerArray),
    '~/geometry_poses': Output(msg.GeometryPoses),
    '~/stopping_poses': Output(msg.GeometryPoses),
    '/diagnostics': Output(DiagnosticArray),
}


def _take_robot(to: Receivers, message: Any, _: MessageArrival) -> None:
    to.log_done(to.robot.take(message.data))
    to.planning.renew()


def _take_semantics(to: Receivers, message: Any, _: MessageArrival) -> None:
    to.log_done(to.robot.take_semantics(message.data))


def _take_object(to: Receivers, message: Any, _: MessageArrival) -> None:
    to.log_done(to.planning.take_object(message))


def _take_attached(to: Receivers, message: Any, _: MessageArrival) -> None:
    to.log_done(to.planning.take_attached(message))


def _take_planning_scene(to: Receivers, message: Any, _: MessageArrival) -> None:
    to.log_done(to.planning.take_scene(message))


# Opened with others by the files that are named beside them.
JOINT_STATES = Input('joint_states', JointState, sensor_data, 'stream')  # joint_listening
TF = Input(
    '/tf', 'tf2_msgs/msg/TFMessage', lambda: transforms(static=False), 'stream'
)  # tf_listening
TF_STATIC = Input(
    '/tf_static', 'tf2_msgs/msg/TFMessage', lambda: transforms(static=True), 'stream'
)  # tf_listening
OCTOMAP = Input(
    '~/obstacles/octomap', 'octomap_msgs/msg/Octomap', newest, 'obstacles'
)  # obstacle_listening

TRACKED_OBJECTS = Input(
    '~/tracked_objects', msg.TrackedObjects, sensor_data, 'tracked'
)  # tracked_listening

INPUTS: tuple[Input, ...] = (
    Input(
        *('~/frame_poses', msg.FramePoses, sensor_data, 'stream'),
        lambda to, message, arrival: to.stream.take_poses(message, *arrival),
        by_bytes=True,
    ),
    Input(
        *('~/frame_twists', msg.FrameTwists, sensor_data, 'stream'),
        lambda to, message, arrival: to.stream.take_twists(message, arrival.waited),
        lambda values: values.closing_speeds,
        by_bytes=True,
    ),
    Input(
        *('~/query_points', PointCloud2, sensor_data, 'beside'),
        lambda to, message, _: to.points.take(message),
    ),
    Input('{robot_description_topic}', String, latched, 'loading', _take_robot),
    Input('{robot_description_semantic_topic}', String, latched, 'loading', _take_semantics),
    Input(
        *('/collision_object', 'moveit_msgs/msg/CollisionObject', _changes, 'loading'),
        *(_take_object, _uses_planning_scene),
    ),
    Input(
        '/attached_collision_object',
        'moveit_msgs/msg/AttachedCollisionObject',
        _changes,
        'loading',
        _take_attached,
        _uses_planning_scene,
    ),
    Input(
        *('/planning_scene', 'moveit_msgs/msg/PlanningScene', _changes, 'loading'),
        *(_take_planning_scene, _uses_planning_scene),
    ),
    Input(
        *('/monitored_planning_scene', 'moveit_msgs/msg/PlanningScene', _changes, 'loading'),
        *(_take_planning_scene, _uses_planning_scene),
    ),
    *(JOINT_STATES, TF, TF_STATIC, OCTOMAP, TRACKED_OBJECTS),
)


def publishers(surface: Surface, values: NodeParameters) -> dict[str, Publisher]:
    """Open the outputs, and return their publishers by topic."""
    return {
        topic: surface.publisher(row.type(), topic, row.profile())
        for topic, row in OUTPUTS.items()
        if row.is_open(values)
    }


def subscribe(
    surface: Surface,
    guard: Guard,
    groups: CallbackGroups,
    values: NodeParameters,
    to: Receivers,
) -> None:
    """Open the inputs that have a handler; ``guard`` counts what a handler refuses."""
    for row in INPUTS:
        topic = row.topic.format_map(asdict(values))
        if row.handler is None or not topic or not row.is_open(values):
            continue

        handle: Callable[[Any, MessageArrival], object] = partial(row.handler, to)
        if row.by_bytes:
            handle = partial(_read_and_handle, pose_reader(row.type()), handle)

        def take(
            message: Any,
            info: MessageInfo,
            handle: Callable[[Any, MessageArrival], object] = handle,
            name: str = topic.removeprefix('~/'),
        ) -> None:
            guard.take(name, handle, message, MessageArrival(waited(info), publisher_of(info)))

        group = getattr(groups, row.group)
        surface.subscription(row.type(), topic, take, row.profile(), group, raw=row.by_bytes)


def _read_and_handle(
    reader: MessageReader,
    handle: Callable[[Any, MessageArrival], object],
    raw: bytes,
    arrival: MessageArrival,
) -> None:
    handle(reader.read(raw, arrival.sender), arrival)
