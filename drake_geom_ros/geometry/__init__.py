"""Scene model and geometry queries, with the public names of ``pydrake.geometry``."""

from typing import TYPE_CHECKING

from drake_geom_ros.geometry._proximity.effects import Effects
from drake_geom_ros.geometry._proximity.engine import ACCURACY_LEVELS, METHODS
from drake_geom_ros.geometry._proximity.kinds import ShapeKind
from drake_geom_ros.geometry._proximity.tolerances import LEVEL_GAPS as ACCURACY_GAPS
from drake_geom_ros.geometry.bounding_boxes import Aabb, Obb
from drake_geom_ros.geometry.closing import ClosingSpeeds, closing_speeds
from drake_geom_ros.geometry.collision_filter_declaration import (
    CollisionFilterDeclaration,
    CollisionFilterScope,
)
from drake_geom_ros.geometry.collision_filter_manager import (
    CollisionFilterManager,
    FilterGroup,
    FilterStatement,
)
from drake_geom_ros.geometry.compilation import compile_all_kernels, kernel_cache
from drake_geom_ros.geometry.contact_material import AddContactMaterial
from drake_geom_ros.geometry.context import SceneGraphContext
from drake_geom_ros.geometry.drake_visualizer import (
    ConnectDrakeVisualizer,
    DispatchLoadMessage,
    DrakeVisualizerPublisher,
)
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
from drake_geom_ros.geometry.geometry_version import GeometryVersion
from drake_geom_ros.geometry.ids import FilterId, FrameId, GeometryId, SourceId
from drake_geom_ros.geometry.in_memory_mesh import InMemoryMesh, MeshSource
from drake_geom_ros.geometry.instances import GeometryFrame, GeometryInstance
from drake_geom_ros.geometry.mesh_shapes import Convex, Mesh
from drake_geom_ros.geometry.mesh_source import MeshData
from drake_geom_ros.geometry.plane import Plane
from drake_geom_ros.geometry.polygon_mesh import PolygonSurfaceMesh, SurfacePolygon
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
from drake_geom_ros.geometry.query_records import (
    PenetrationAsPointPair,
    SignedDistancePair,
    SignedDistanceToPoint,
)
from drake_geom_ros.geometry.query_results import (
    PenetrationResults,
    PointDistanceResults,
    SignedDistanceResults,
)
from drake_geom_ros.geometry.render.cameras import (
    ClippingRange,
    ColorRenderCamera,
    DepthRange,
    DepthRenderCamera,
    RenderCameraCore,
)
from drake_geom_ros.geometry.render.exact import (
    MakeRenderEngineExact,
    RenderEngineExact,
    RenderEngineExactParams,
)
from drake_geom_ros.geometry.render.render_engine import RenderedImages, RenderEngine
from drake_geom_ros.geometry.render.render_label import RenderLabel
from drake_geom_ros.geometry.render.vtk_engine import (
    MakeRenderEngineVtk,
    RenderEngineVtk,
    RenderEngineVtkParams,
)
from drake_geom_ros.geometry.rgba import Rgba
from drake_geom_ros.geometry.scalar_templates import (
    FramePoseVector_,
    PenetrationAsPointPair_,
    Plane_,
    PolygonSurfaceMesh_,
    QueryObject_,
    SceneGraphInspector_,
    SignedDistancePair_,
    SignedDistanceToPoint_,
    SurfaceMesh_,
    SurfaceVertex_,
    TriangleSurfaceMesh_,
)
from drake_geom_ros.geometry.scene_graph import SceneGraph, SceneGraph_
from drake_geom_ros.geometry.scene_graph_inspector import SceneGraphInspector
from drake_geom_ros.geometry.shape_measures import (
    CalcObb,
    CalcVolume,
    ComputeAabbForTriangleMesh,
    ComputeObbForTriangleMesh,
)
from drake_geom_ros.geometry.shapes import (
    Box,
    Capsule,
    Cylinder,
    Ellipsoid,
    HalfSpace,
    MeshcatCone,
    Shape,
    Sphere,
)
from drake_geom_ros.geometry.surface_mesh import (
    ReadObjToSurfaceMesh,
    ReadObjToTriangleSurfaceMesh,
    SurfaceFace,
    SurfaceMesh,
    SurfaceTriangle,
    SurfaceVertex,
    TriangleSurfaceMesh,
)
from drake_geom_ros.math.missing import refuse_missing

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
    'MeshcatCone',
    'MeshData',
    'MeshSource',
    'InMemoryMesh',
    'CalcVolume',
    'CalcObb',
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
    'AddContactMaterial',
    'GeometrySet',
    'FramePoseVector',
    # the scene,
    'SceneGraph',
    'SceneGraphInspector',
    'GeometryVersion',
    'CollisionFilterManager',
    'CollisionFilterDeclaration',
    'CollisionFilterScope',
    # cameras and what makes images,
    'ColorRenderCamera',
    'DepthRenderCamera',
    'RenderCameraCore',
    'ClippingRange',
    'DepthRange',
    'RenderLabel',
    'RenderEngine',
    'MakeRenderEngineVtk',
    'RenderEngineVtkParams',
    # queries and what they return,
    'QueryObject',
    'PenetrationAsPointPair',
    'SignedDistancePair',
    'SignedDistanceToPoint',
    # Drake's visualiser,
    'ConnectDrakeVisualizer',
    'DispatchLoadMessage',
    # boxes, planes and meshes,
    'Obb',
    'Aabb',
    'Plane',
    'ComputeAabbForTriangleMesh',
    'ComputeObbForTriangleMesh',
    'TriangleSurfaceMesh',
    'SurfaceTriangle',
    'PolygonSurfaceMesh',
    'SurfacePolygon',
    'ReadObjToTriangleSurfaceMesh',
    # the last of them by the names of 2020.
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
    'Plane_',
    'PolygonSurfaceMesh_',
    'SurfaceMesh_',
    'SurfaceVertex_',
    'TriangleSurfaceMesh_',
    # Ours: contexts, compiling, result sequences, levels of accuracy, what there is to know of
    # filters,
    'SceneGraphContext',
    'compile_all_kernels',
    'kernel_cache',
    'PenetrationResults',
    'SignedDistanceResults',
    'PointDistanceResults',
    'ClosingSpeeds',
    'closing_speeds',
    'DrakeVisualizerPublisher',
    'Effects',
    'ACCURACY_LEVELS',
    'ACCURACY_GAPS',
    'METHODS',
    'ShapeKind',
    'FilterGroup',
    'FilterStatement',
    # the renderer that is exact, and the one by VTK,
    'MakeRenderEngineExact',
    'RenderEngineExact',
    'RenderEngineExactParams',
    'RenderEngineVtk',
    'RenderedImages',
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

if not TYPE_CHECKING:  # mypy would take any name for one that is there
    __getattr__ = refuse_missing(__name__)
