"""Types of the messages that come in, as far as they are read: what ROS generates has no types.

A class has the fields of the message that its docstring names; any object with these will do.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Protocol


class TimeMessage(Protocol):
    """builtin_interfaces/Time."""

    @property
    def sec(self) -> int:
        """Whole seconds [s]."""

    @property
    def nanosec(self) -> int:
        """The rest [ns]."""


class HeaderMessage(Protocol):
    """std_msgs/Header: when something was, and the frame that it is measured in."""

    stamp: TimeMessage
    frame_id: str


class StampedMessage(Protocol):
    """Any message with a header."""

    header: HeaderMessage


class VectorMessage(Protocol):
    """geometry_msgs/Vector3, or geometry_msgs/Point [m]."""

    x: float
    y: float
    z: float


class QuaternionMessage(Protocol):
    """geometry_msgs/Quaternion."""

    x: float
    y: float
    z: float
    w: float


class PoseMessage(Protocol):
    """geometry_msgs/Pose."""

    position: VectorMessage
    orientation: QuaternionMessage


class TransformMessage(Protocol):
    """geometry_msgs/Transform."""

    translation: VectorMessage
    rotation: QuaternionMessage


class TransformStampedMessage(StampedMessage, Protocol):
    """geometry_msgs/TransformStamped: the pose of a child frame in that of the header."""

    child_frame_id: str
    transform: TransformMessage


class TFMessage(Protocol):
    """tf2_msgs/TFMessage."""

    transforms: Sequence[TransformStampedMessage]


class ListedFramesMessage(StampedMessage, Protocol):
    """Frames of drake_geom_msgs/FramePoses or drake_geom_msgs/FrameTwists, by name or by id."""

    source: str
    frame_names: Sequence[str]
    frame_ids: Sequence[int]


class FramePosesMessage(ListedFramesMessage, Protocol):
    """drake_geom_msgs/FramePoses: x y z [m] qx qy qz qw of each frame."""

    poses: Sequence[float]


class FrameTwistsMessage(ListedFramesMessage, Protocol):
    """drake_geom_msgs/FrameTwists: wx wy wz [rad/s] vx vy vz [m/s] of each frame."""

    twists: Sequence[float]


class JointStateMessage(StampedMessage, Protocol):
    """sensor_msgs/JointState: values [rad] or [m] and speeds by joint."""

    name: Sequence[str]
    position: Sequence[float]
    velocity: Sequence[float]


class TrajectoryPointMessage(Protocol):
    """trajectory_msgs/JointTrajectoryPoint."""

    positions: Sequence[float]
    velocities: Sequence[float]
    accelerations: Sequence[float]
    time_from_start: TimeMessage


class TrajectoryMessage(StampedMessage, Protocol):
    """trajectory_msgs/JointTrajectory."""

    joint_names: Sequence[str]
    points: Sequence[TrajectoryPointMessage]


class MultiDofTrajectoryMessage(StampedMessage, Protocol):
    """trajectory_msgs/MultiDOFJointTrajectory."""

    joint_names: Sequence[str]
    points: Sequence[Any]


class JointPositionsMessage(Protocol):
    """drake_geom_msgs/JointPositions: values [rad] or [m] by joint."""

    @property
    def names(self) -> Sequence[str]:
        """The joints."""

    @property
    def positions(self) -> Sequence[float]:
        """Their values."""


class GeometrySetMessage(Protocol):
    """drake_geom_msgs/GeometrySet: geometries, and frames that stand for all on them."""

    frames: Sequence[str]
    frame_ids: Sequence[int]
    geometries: Sequence[str]
    geometry_ids: Sequence[int]


class FilterStatementMessage(Protocol):
    """drake_geom_msgs/CollisionFilterStatement."""

    operation: int
    set_a: GeometrySetMessage
    set_b: GeometrySetMessage


class FilterDeclarationMessage(Protocol):
    """drake_geom_msgs/CollisionFilterDeclaration."""

    statements: Sequence[FilterStatementMessage]


class ShapeMessage(Protocol):
    """drake_geom_msgs/Shape: its type by number, and its sizes [m]."""

    type: int
    dimensions: Sequence[float]
    mesh_uri: str
    vertices: Sequence[float]
    triangles: Sequence[int]


class PropertyMessage(Protocol):
    """drake_geom_msgs/Property; the value is that of a parameter."""

    group: str
    name: str
    value: Any


class RoleMessage(Protocol):
    """drake_geom_msgs/Role."""

    role: int
    properties: Sequence[PropertyMessage]


class NewGeometryMessage(Protocol):
    """drake_geom_msgs/NewGeometry: on a frame, or where another geometry is."""

    frame: str
    parent_geometry: str
    name: str
    pose: PoseMessage
    shape: ShapeMessage
    roles: Sequence[RoleMessage]


class CameraMessage(Protocol):
    """drake_geom_msgs/Camera."""

    name: str
    frame: str
    pose: PoseMessage
    width: int
    height: int
    fov_y: float
    intrinsics: Sequence[float]
    near: float
    far: float
    rate: float
    images: Sequence[str]
    shows: str


class RuleMessage(Protocol):
    """drake_geom_msgs/ProximityRule: distances [m], times [s]."""

    name: str
    set_a: Sequence[str]
    set_b: Sequence[str]
    level: int
    enter: float
    leave: float
    hold: float
    enter_after: float
    min_time_to_contact: float
    when_stale: str
    scale: Sequence[float]
    acknowledge: bool
    min_points: int
    joint_names: Sequence[str]
    decelerations: Sequence[float]
    stopping_times: Sequence[float]
    reaction_time: float
    margin: float
    max_speed: float
    stop_category: int


class PointFieldMessage(Protocol):
    """sensor_msgs/PointField: a number of each point of a cloud."""

    name: str
    offset: int
    datatype: int
    count: int


class CloudMessage(StampedMessage, Protocol):
    """sensor_msgs/PointCloud2."""

    height: int
    width: int
    fields: Sequence[PointFieldMessage]
    is_bigendian: bool
    point_step: int
    row_step: int
    data: bytes


class ScanMessage(StampedMessage, Protocol):
    """sensor_msgs/LaserScan."""

    angle_min: float
    angle_increment: float
    time_increment: float
    range_min: float
    range_max: float
    ranges: Sequence[float]


class RangeMessage(StampedMessage, Protocol):
    """sensor_msgs/Range."""

    field_of_view: float
    min_range: float
    max_range: float
    range: float


class GridInfoMessage(Protocol):
    """nav_msgs/MapMetaData."""

    resolution: float
    width: int
    height: int
    origin: PoseMessage


class GridMessage(StampedMessage, Protocol):
    """nav_msgs/OccupancyGrid."""

    info: GridInfoMessage
    data: Sequence[int]


class OctomapMessage(StampedMessage, Protocol):
    """octomap_msgs/Octomap."""

    binary: bool
    id: str
    resolution: float
    data: bytes
