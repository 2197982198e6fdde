"""Scene model and geometry queries, with the public names of ``pydrake.geometry``."""

from drake_geom_ros.geometry._proximity.engine import ACCURACY_LEVELS, METHODS, Effects
from drake_geom_ros.geometry._proximity.kinds import ShapeKind
from drake_geom_ros.geometry._proximity.tolerances import LEVEL_GAPS as ACCURACY_GAPS
from drake_geom_ros.geometry.collision_filter_declaration import (
    CollisionFilterDeclaration,
    CollisionFilterScope,
)
from drake_geom_ros.geometry.collision_filter_manager import (
    CollisionFilterManager,
    FilterGroup,
    FilterStatement,
)
from drake_geom_ros.geometry.context import SceneGraphContext
from drake_geom_ros.geometry.errors import (
    ArgumentError,
    ArgumentTypeError,
    DuplicateError,
    FilterError,
    GeometryError,
    MeshFileError,
    OwnershipError,
    PoseError,
    RoleError,
    UnknownIdError,
)
from drake_geom_ros.geometry.frame_pose_vector import FramePoseVector
from drake_geom_ros.geometry.geometry_set import GeometrySet
from drake_geom_ros.geometry.ids import FilterId, FrameId, GeometryId, SourceId
from drake_geom_ros.geometry.instances import GeometryFrame, GeometryInstance
from drake_geom_ros.geometry.mesh_source import MeshData
from drake_geom_ros.geometry.properties import (
    GeometryProperties,
    IllustrationProperties,
    MakePhongIllustrationProperties,
    PerceptionProperties,
    ProximityProperties,
    Role,
    RoleAssign,
)
from drake_geom_ros.geometry.query_object import QueryObject
from drake_geom_ros.geometry.query_results import (
    PenetrationAsPointPair,
    PenetrationResults,
    PointDistanceResults,
    SignedDistancePair,
    SignedDistanceResults,
    SignedDistanceToPoint,
)
from drake_geom_ros.geometry.rgba import Rgba
from drake_geom_ros.geometry.scalar_templates import (
    FramePoseVector_,
    PenetrationAsPointPair_,
    QueryObject_,
    SceneGraph_,
    SceneGraphInspector_,
    SignedDistancePair_,
    SignedDistanceToPoint_,
    SurfaceMesh_,
    SurfaceVertex_,
)
from drake_geom_ros.geometry.scene_graph import SceneGraph
from drake_geom_ros.geometry.scene_graph_inspector import SceneGraphInspector
from drake_geom_ros.geometry.shapes import (
    Box,
    Capsule,
    Convex,
    Cylinder,
    Ellipsoid,
    HalfSpace,
    Mesh,
    Shape,
    Sphere,
)
from drake_geom_ros.geometry.surface_mesh import (
    ReadObjToSurfaceMesh,
    SurfaceFace,
    SurfaceMesh,
    SurfaceVertex,
)

__all__ = [
    # As in pydrake.geometry: shapes,
    'Shape',
    'Sphere',
    'Box',
    'Capsule',
    'Cylinder',
    'Ellipsoid',
    'HalfSpace',
    'Convex',
    'Mesh',
    'MeshData',
    # ids,
    'SourceId',
    'FrameId',
    'GeometryId',
    'FilterId',
    # what is registered, and with what properties,
    'GeometryFrame',
    'GeometryInstance',
    'GeometryProperties',
    'ProximityProperties',
    'IllustrationProperties',
    'PerceptionProperties',
    'Rgba',
    'Role',
    'RoleAssign',
    'MakePhongIllustrationProperties',
    'GeometrySet',
    'FramePoseVector',
    # the scene,
    'SceneGraph',
    'SceneGraphInspector',
    'CollisionFilterManager',
    'CollisionFilterDeclaration',
    'CollisionFilterScope',
    # queries and what they return,
    'QueryObject',
    'PenetrationAsPointPair',
    'SignedDistancePair',
    'SignedDistanceToPoint',
    # meshes.
    'SurfaceMesh',
    'SurfaceVertex',
    'SurfaceFace',
    'ReadObjToSurfaceMesh',
    # The same by scalar type.
    'FramePoseVector_',
    'PenetrationAsPointPair_',
    'QueryObject_',
    'SceneGraph_',
    'SceneGraphInspector_',
    'SignedDistancePair_',
    'SignedDistanceToPoint_',
    'SurfaceMesh_',
    'SurfaceVertex_',
    # Ours: contexts, result sequences, levels of accuracy, what there is to know of filters,
    'SceneGraphContext',
    'PenetrationResults',
    'SignedDistanceResults',
    'PointDistanceResults',
    'Effects',
    'ACCURACY_LEVELS',
    'ACCURACY_GAPS',
    'METHODS',
    'ShapeKind',
    'FilterGroup',
    'FilterStatement',
    # and errors.
    'GeometryError',
    'ArgumentError',
    'ArgumentTypeError',
    'UnknownIdError',
    'OwnershipError',
    'DuplicateError',
    'RoleError',
    'PoseError',
    'FilterError',
    'MeshFileError',
]
