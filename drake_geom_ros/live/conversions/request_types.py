"""Types of the requests of services, with the fields that handlers read.

As in ``message_types``: a class has the fields of the service that its docstring names, and any
object with these will do. Requests of the same fields share a class.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Protocol

from drake_geom_ros.live.conversions.message_types import (
    CameraMessage,
    FilterDeclarationMessage,
    FramePosesMessage,
    JointPositionsMessage,
    MultiDofTrajectoryMessage,
    NewGeometryMessage,
    PoseMessage,
    RoleMessage,
    RuleMessage,
    ShapeMessage,
    TrajectoryMessage,
)


class EmptyRequest(Protocol):
    """FlattenFilters, GetFilters, ListCameras, ListObstacleSources, ListProximityRules."""


class NamedRequest(Protocol):
    """RegisterSource, and what removes a camera, a rule, a sensor or a watched trajectory."""

    name: str


class OfSourceRequest(Protocol):
    """RemoveSource."""

    source: str


class OfGeometryRequest(Protocol):
    """RemoveGeometry."""

    geometry: str


class RegisterFrameRequest(NamedRequest, OfSourceRequest, Protocol):
    """RegisterFrame."""

    parent: str
    frame_group: int


class RegisterGeometryRequest(OfSourceRequest, NewGeometryMessage, Protocol):
    """RegisterGeometry: a geometry and its source."""


class RegisterGeometriesRequest(OfSourceRequest, Protocol):
    """RegisterGeometries."""

    geometries: Sequence[NewGeometryMessage]


class AssignRoleRequest(OfGeometryRequest, Protocol):
    """AssignRole: 0 (NEW) or 1 (REPLACE)."""

    role: RoleMessage
    assign: int


class RemoveRoleRequest(OfGeometryRequest, Protocol):
    """RemoveRole: a role by its number in drake_geom_msgs/Role."""

    role: int


class ChangeShapeRequest(OfGeometryRequest, Protocol):
    """ChangeShape."""

    shape: ShapeMessage


class DetachRequest(Protocol):
    """Detach."""

    frame: str
    pose_given: bool
    pose: PoseMessage


class AttachRequest(DetachRequest, Protocol):
    """Attach."""

    parent: str
    part_of_robot: bool
    touch_links: Sequence[str]


class ApplyFilterRequest(Protocol):
    """ApplyFilter."""

    declaration: FilterDeclarationMessage


class LeaseRequest(Protocol):
    """The lease [s] of a transient filter, and who asks."""

    lease: float
    owner: str


class ApplyTransientFilterRequest(ApplyFilterRequest, LeaseRequest, Protocol):
    """ApplyTransientFilter."""


class RemoveFilterRequest(Protocol):
    """RemoveFilter."""

    filter_id: int
    owner: str


class RenewFilterRequest(RemoveFilterRequest, LeaseRequest, Protocol):
    """RenewFilter."""


class AddRuleRequest(Protocol):
    """AddProximityRule."""

    rule: RuleMessage


class AcknowledgeRuleRequest(NamedRequest, Protocol):
    """AcknowledgeRule: the last event of a rule that was seen."""

    sequence: int


class AddObstacleSourceRequest(NamedRequest, Protocol):
    """AddObstacleSource: settings as YAML."""

    settings: str


class ClearObstaclesRequest(Protocol):
    """ClearObstacles."""

    map: str


class SavedRequest(Protocol):
    """SaveScene."""

    path: str


class LoadObstaclesRequest(SavedRequest, Protocol):
    """LoadObstacles: the size of cells [m]."""

    resolution: float


class SaveObstaclesRequest(SavedRequest, ClearObstaclesRequest, Protocol):
    """SaveObstacles."""


class LoadSceneRequest(Protocol):
    """LoadScene."""

    path: str
    text: str
    format: str
    srdf: str
    replace: bool
    replaced_sources: Sequence[str]


class StateRequest(Protocol):
    """FindCollisionCandidates, HasCollisions: poses and joint values that are assumed."""

    poses: FramePosesMessage
    joints: JointPositionsMessage


class QueryRequest(StateRequest, Protocol):
    """ComputePointPairPenetration."""

    accuracy: str


class PairwiseRequest(QueryRequest, Protocol):
    """ComputeSignedDistancePairwise: a limit [m]."""

    max_distance: float


class TwoGeometriesRequest(Protocol):
    """ExplainFilter."""

    geometry_a: str
    geometry_b: str


class OnePairRequest(QueryRequest, TwoGeometriesRequest, Protocol):
    """ComputeSignedDistancePair."""


class ToPointRequest(QueryRequest, Protocol):
    """ComputeSignedDistanceToPoint: x y z of each point [m]."""

    points: Sequence[float]
    threshold: float


class ContactSurfacesRequest(StateRequest, Protocol):
    """ComputeContactSurfaces."""

    polygons: bool
    with_fallback: bool


class GetPoseRequest(Protocol):
    """GetPose: relative to 0 (WORLD) or 1 (PARENT)."""

    frame: str
    geometry: str
    relative_to: int


class PoseAgesRequest(Protocol):
    """GetPoseAges."""

    frames: Sequence[str]


class JointNamesRequest(Protocol):
    """GetJointPositions."""

    names: Sequence[str]


class EvaluateStatesRequest(Protocol):
    """EvaluateStates: one number for each joint of each state."""

    joint_names: Sequence[str]
    positions: Sequence[float]
    poses: FramePosesMessage
    want: str
    clearance: float
    max_distance: float
    stop_at_first: bool
    ignore_limits: bool
    accuracy: str


class PathRequest(Protocol):
    """The fields that CheckMotion and WatchTrajectory have in common."""

    path: TrajectoryMessage
    min_distance: float
    profile: str
    accuracy: str
    ignore_start_contacts: bool
    ignore_limits: bool
    ignore_foreign_joints: bool


class CheckMotionRequest(PathRequest, Protocol):
    """CheckMotion."""

    start: FramePosesMessage
    end: FramePosesMessage
    start_joints: JointPositionsMessage
    time_tolerance: float
    interpolation: str
    max_evaluations: int
    start_tolerance: float
    multi_dof_path: MultiDofTrajectoryMessage
    start_now: bool
    approach_time: float
    clearance_intervals: int


class WatchTrajectoryRequest(PathRequest, NamedRequest, Protocol):
    """WatchTrajectory."""

    deviation_tolerance: float
    time_budget: float


class AddCameraRequest(Protocol):
    """AddCamera."""

    camera: CameraMessage


class RenderImageRequest(StateRequest, Protocol):
    """RenderImage: a camera by name, or one that is given."""

    camera: str
    given: CameraMessage
    images: Sequence[str]


class StateValidityRequest(Protocol):
    """moveit_msgs/GetStateValidity."""

    robot_state: Any
    group_name: str
    constraints: Any
