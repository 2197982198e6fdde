"""The contract of the ROS surface: what may be added to, but never renamed or dropped.

Constants and fields in their order; `---` parts the request of a service from its answer, whose
first two fields, `bool success` and `string message`, every service has and no line repeats.
"""

import re


def definitions(text):
    """Return {name: fields} of definitions that each begin a line; indented lines go on."""
    lines = re.sub(r'\n +', ' ', text.strip()).splitlines()
    return dict(line.split(': ', 1) for line in lines)


MESSAGES = definitions("""
FramePoses: std_msgs/Header header, string source, string[] frame_names, uint64[] frame_ids,
    float64[] poses
PenetrationPairs: uint8 METHOD_CLOSED_FORM=1, uint8 METHOD_ITERATIVE=2, uint8 METHOD_MESH=3,
    uint8 METHOD_BOUND_ONLY=4, std_msgs/Header header, uint64 scene_version, uint64[] id_a,
    uint64[] id_b, float64[] p_wca, float64[] p_wcb, float64[] nhat_ba_w, float64[] depth,
    float64[] error_bound, uint8[] method
SignedDistancePairs: uint8 METHOD_CLOSED_FORM=1, uint8 METHOD_ITERATIVE=2, uint8 METHOD_MESH=3,
    uint8 METHOD_BOUND_ONLY=4, std_msgs/Header header, uint64 scene_version, float64
    max_distance, uint64[] id_a, uint64[] id_b, float64[] p_aca, float64[] p_bcb, float64[]
    nhat_ba_w, float64[] distance, bool[] is_nhat_ba_w_unique, float64[] error_bound, uint8[]
    method
PointDistances: std_msgs/Header header, uint64 scene_version, float64 threshold, uint32[]
    point_index, uint64[] id_g, float64[] p_gn, float64[] distance, float64[] grad_w, bool[]
    is_grad_w_unique
GeometryPoses: std_msgs/Header header, uint64 scene_version, uint64[] ids, float64[] poses
CycleReport: std_msgs/Header header, uint32 frames_moved, uint32 geometries_updated, uint32
    broadphase_pairs, uint32 filtered_pairs, uint32 cached_pairs, uint8[] methods, uint32[]
    method_pairs, uint32 unpublished_messages, string[] effects, bool[] effect_ran, uint32[]
    effect_counts, float64[] effect_seconds, string[] effect_reasons
Scene: uint64 scene_version, SceneSource[] sources, SceneFrame[] frames, SceneGeometry[]
    geometries
SceneSource: uint64 id, string name
SceneFrame: uint64 id, string name, uint64 source_id, uint64 parent_id, int32 frame_group
SceneGeometry: uint64 id, string name, uint64 frame_id, geometry_msgs/Pose pose, Shape shape,
    Role[] roles
Shape: uint8 SPHERE=1, uint8 BOX=2, uint8 CAPSULE=3, uint8 CYLINDER=4, uint8 ELLIPSOID=5, uint8
    HALF_SPACE=6, uint8 CONVEX=7, uint8 MESH=8, uint8 type, float64[] dimensions, string
    mesh_uri, float64[] vertices, uint32[] triangles
GeometrySet: string[] frames, string[] geometries, uint64[] frame_ids, uint64[] geometry_ids
CollisionFilterStatement: uint8 EXCLUDE_WITHIN=1, uint8 EXCLUDE_BETWEEN=2, uint8
    ALLOW_WITHIN=3, uint8 ALLOW_BETWEEN=4, uint8 operation, GeometrySet set_a, GeometrySet
    set_b
CollisionFilterDeclaration: CollisionFilterStatement[] statements
Role: uint8 PROXIMITY=1, uint8 ILLUSTRATION=2, uint8 PERCEPTION=3, uint8 role, Property[]
    properties
Property: string group, string name, rcl_interfaces/ParameterValue value
Camera: string name, string frame, geometry_msgs/Pose pose, uint32 width, uint32 height, float64
    fov_y, float64[] intrinsics, float64 near, float64 far, float64 rate, string[] images,
    string shows
LabelLegend: std_msgs/Header header, uint64 scene_version, int32[] labels, uint64[] ids,
    string[] geometries
""")

SERVICES = definitions("""
RegisterSource: string name --- uint64 source_id
RegisterFrame: string source, string name, string parent, int32 frame_group --- uint64 frame_id
RegisterGeometry: string source, string frame, string parent_geometry, string name,
    geometry_msgs/Pose pose, Shape shape, Role[] roles --- uint64 geometry_id
AssignRole: uint8 NEW=0, uint8 REPLACE=1, string geometry, Role role, uint8 assign ---
RemoveRole: string geometry, uint8 role --- uint32 count
RemoveGeometry: string geometry ---
ChangeShape: string geometry, Shape shape ---
LoadScene: string path, string text, string format, string srdf, bool replace --- uint32
    frames, uint32 geometries
SaveScene: string path --- string text
ApplyFilter: CollisionFilterDeclaration declaration ---
ApplyTransientFilter: CollisionFilterDeclaration declaration, string owner, float64 lease ---
    uint64 filter_id
RenewFilter: uint64 filter_id, float64 lease --- bool active
RemoveFilter: uint64 filter_id --- bool removed
GetFilters: --- bool has_transient_history, uint64[] active_filter_ids, uint64 filtered_pairs
ExplainFilter: string geometry_a, string geometry_b --- bool filtered, string[] reasons
ComputePointPairPenetration: FramePoses poses, string accuracy --- PenetrationPairs result
ComputeSignedDistancePairwise: float64 max_distance, FramePoses poses, string accuracy ---
    SignedDistancePairs result
ComputeSignedDistancePair: string geometry_a, string geometry_b, FramePoses poses, string
    accuracy --- SignedDistancePairs result
ComputeSignedDistanceToPoint: float64[] points, float64 threshold, FramePoses poses, string
    accuracy --- PointDistances result
FindCollisionCandidates: FramePoses poses --- uint64[] id_a, uint64[] id_b
HasCollisions: FramePoses poses --- bool has_collisions
CheckMotion: FramePoses start, FramePoses end, JointPositions start_joints,
    trajectory_msgs/JointTrajectory path, float64 min_distance, float64 time_tolerance, string
    interpolation, uint32 max_evaluations, string accuracy --- uint8 CLEAR=1, uint8 CONTACT=2,
    uint8 UNKNOWN=3, uint8 outcome, float64[2] times, float64 last_free, string geometry_a, string
    geometry_b, uint64 id_a, uint64 id_b, float64 distance, float64 lower_bound, uint32 evaluations
GetPose: uint8 WORLD=0, uint8 PARENT=1, string frame, string geometry, uint8 relative_to ---
    geometry_msgs/PoseStamped pose
AddCamera: Camera camera ---
RemoveCamera: string name ---
ListCameras: --- Camera[] cameras
RenderImage: string camera, Camera given, FramePoses poses, string[] images --- sensor_msgs/Image
    color, sensor_msgs/Image depth, sensor_msgs/Image label, sensor_msgs/CameraInfo camera_info,
    LabelLegend legend
""")
