"""Scene model and geometry queries, with the public names of ``pydrake.geometry``.

Sources register frames and geometries in a ``SceneGraph``, which makes contexts that hold their
poses. The ``QueryObject`` of a context answers queries: penetration, signed distances of pairs and
to points, contact surfaces, images, whole motions. Every distance has a certified error bound.
Lengths are in metres.
"""

from typing import TYPE_CHECKING

from drake_geom_ros.geometry._proximity.effects import Effects
from drake_geom_ros.geometry._proximity.engine.engine import ACCURACY_LEVELS, METHODS
from drake_geom_ros.geometry._proximity.filters.log import FilterOperation
from drake_geom_ros.geometry._proximity.kinds import ShapeKind
from drake_geom_ros.geometry._proximity.tolerances import LEVEL_GAPS as ACCURACY_GAPS
from drake_geom_ros.geometry.autodiff.scalar_templates import (
    ContactSurface_,
    FramePoseVector_,
    PenetrationAsPointPair_,
    Plane_,
    PolygonSurfaceMesh_,
    PolygonSurfaceMeshFieldLinear_,
    QueryObject_,
    SceneGraphInspector_,
    SignedDistancePair_,
    SignedDistanceToPoint_,
    SurfaceMesh_,
    SurfaceVertex_,
    TriangleSurfaceMesh_,
    TriangleSurfaceMeshFieldLinear_,
    VolumeMesh_,
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
from drake_geom_ros.geometry.hydroelastic.bodies import HydroelasticType
from drake_geom_ros.geometry.ids import FilterId, FrameId, GeometryId, SourceId
from drake_geom_ros.geometry.meshes.in_memory import InMemoryMesh, MeshSource
from drake_geom_ros.geometry.meshes.polygon_mesh import PolygonSurfaceMesh, SurfacePolygon
from drake_geom_ros.geometry.meshes.source import MeshData
from drake_geom_ros.geometry.meshes.surface_fields import (
    PolygonSurfaceMeshFieldLinear,
    TriangleSurfaceMeshFieldLinear,
)
from drake_geom_ros.geometry.meshes.surface_mesh import (
    ReadObjToSurfaceMesh,
    ReadObjToTriangleSurfaceMesh,
    SurfaceFace,
    SurfaceMesh,
    SurfaceTriangle,
    SurfaceVertex,
    TriangleSurfaceMesh,
)
from drake_geom_ros.geometry.meshes.volume_files import RefineVolumeMeshIntoVtkFileContents
from drake_geom_ros.geometry.meshes.volume_mesh import VolumeElement, VolumeMesh
from drake_geom_ros.geometry.meshes.volume_surface import (
    ConvertVolumeToSurfaceMesh,
    RefineVolumeMesh,
)
from drake_geom_ros.geometry.model.candidate_pairs import CandidatePairs
from drake_geom_ros.geometry.model.collision_filter_declaration import (
    CollisionFilterDeclaration,
    CollisionFilterScope,
)
from drake_geom_ros.geometry.model.collision_filter_manager import (
    CollisionFilterManager,
    FilterGroup,
    FilterStatement,
)
from drake_geom_ros.geometry.model.contact_material import AddContactMaterial, CoulombFriction
from drake_geom_ros.geometry.model.frame_pose_vector import FramePoseVector
from drake_geom_ros.geometry.model.geometry_set import GeometrySet
from drake_geom_ros.geometry.model.geometry_version import GeometryVersion
from drake_geom_ros.geometry.model.hydroelastic_properties import (
    AddCompliantHydroelasticProperties,
    AddCompliantHydroelasticPropertiesForHalfSpace,
    AddRigidHydroelasticProperties,
)
from drake_geom_ros.geometry.model.instances import GeometryFrame, GeometryInstance
from drake_geom_ros.geometry.model.properties import (
    GeometryProperties,
    IllustrationProperties,
    MakePhongIllustrationProperties,
    PerceptionProperties,
    ProximityProperties,
    Role,
    RoleAssign,
)
from drake_geom_ros.geometry.model.rgba import Rgba
from drake_geom_ros.geometry.model.scene_graph_config import (
    DefaultProximityProperties,
    SceneGraphConfig,
)
from drake_geom_ros.geometry.model.scene_graph_inspector import SceneGraphInspector
from drake_geom_ros.geometry.queries.accuracy import Accuracy, AccuracyLike, accuracy_of
from drake_geom_ros.geometry.queries.closing import ClosingSpeeds, closing_speeds
from drake_geom_ros.geometry.queries.contact_surfaces import (
    ContactSurface,
    ContactSurfaceResults,
    HydroelasticContactRepresentation,
)
from drake_geom_ros.geometry.queries.context import SceneGraphContext
from drake_geom_ros.geometry.queries.motion_checks import MotionCheck
from drake_geom_ros.geometry.queries.query_object import QueryObject
from drake_geom_ros.geometry.queries.query_records import (
    PenetrationAsPointPair,
    SignedDistancePair,
    SignedDistanceToPoint,
)
from drake_geom_ros.geometry.queries.query_results import (
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
from drake_geom_ros.geometry.render.exact import MakeRenderEngineExact, RenderEngineExact
from drake_geom_ros.geometry.render.exact_params import RenderEngineExactParams
from drake_geom_ros.geometry.render.render_engine import RenderedImages, RenderEngine
from drake_geom_ros.geometry.render.render_label import RenderLabel
from drake_geom_ros.geometry.render.vtk.engine import (
    MakeRenderEngineVtk,
    RenderEngineVtk,
    RenderEngineVtkParams,
)
from drake_geom_ros.geometry.scene.compilation import (
    compile_all_kernels,
    kernel_cache,
    kernel_state,
)
from drake_geom_ros.geometry.scene.scene_graph import SceneGraph, SceneGraph_
from drake_geom_ros.geometry.shapes.bounding_boxes import Aabb, Obb
from drake_geom_ros.geometry.shapes.from_meshes import Convex, Mesh
from drake_geom_ros.geometry.shapes.height_field import HeightField
from drake_geom_ros.geometry.shapes.measures import (
    CalcObb,
    CalcVolume,
    ComputeAabbForTriangleMesh,
    ComputeAabbForVolumeMesh,
    ComputeObbForTriangleMesh,
    ComputeObbForVolumeMesh,
)
from drake_geom_ros.geometry.shapes.plane import Plane
from drake_geom_ros.geometry.shapes.primitives import (
    Box,
    Capsule,
    Cylinder,
    Ellipsoid,
    HalfSpace,
    MeshcatCone,
    Shape,
    Sphere,
)
from drake_geom_ros.geometry.shapes.sensed import OccupiedCells, PointCloud
from drake_geom_ros.geometry.visualizer.drake_visualizer import (
    ConnectDrakeVisualizer,
    DispatchLoadMessage,
    DrakeVisualizerPublisher,
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
    'HeightField',
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
    # frames, geometries and their properties,
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
    'CoulombFriction',
    'AddRigidHydroelasticProperties',
    'AddCompliantHydroelasticProperties',
    'AddCompliantHydroelasticPropertiesForHalfSpace',
    'GeometrySet',
    'FramePoseVector',
    # the scene,
    'SceneGraph',
    'SceneGraphConfig',
    'DefaultProximityProperties',
    'SceneGraphInspector',
    'GeometryVersion',
    'CandidatePairs',
    'CollisionFilterManager',
    'CollisionFilterDeclaration',
    'CollisionFilterScope',
    # cameras and renderers,
    'ColorRenderCamera',
    'DepthRenderCamera',
    'RenderCameraCore',
    'ClippingRange',
    'DepthRange',
    'RenderLabel',
    'RenderEngine',
    'MakeRenderEngineVtk',
    'RenderEngineVtkParams',
    # queries and their results,
    'QueryObject',
    'PenetrationAsPointPair',
    'SignedDistancePair',
    'SignedDistanceToPoint',
    'ContactSurface',
    'HydroelasticContactRepresentation',
    'PolygonSurfaceMeshFieldLinear',
    'TriangleSurfaceMeshFieldLinear',
    # Drake's visualiser,
    'ConnectDrakeVisualizer',
    'DispatchLoadMessage',
    # boxes, planes and meshes,
    'Obb',
    'Aabb',
    'Plane',
    'ComputeAabbForTriangleMesh',
    'ComputeAabbForVolumeMesh',
    'ComputeObbForTriangleMesh',
    'ComputeObbForVolumeMesh',
    'TriangleSurfaceMesh',
    'SurfaceTriangle',
    'PolygonSurfaceMesh',
    'SurfacePolygon',
    'ReadObjToTriangleSurfaceMesh',
    'VolumeMesh',
    'VolumeElement',
    'ConvertVolumeToSurfaceMesh',
    'RefineVolumeMesh',
    'RefineVolumeMeshIntoVtkFileContents',
    # the last of them by the names of 2020.
    'SurfaceMesh',
    'SurfaceVertex',
    'SurfaceFace',
    'ReadObjToSurfaceMesh',
    # The same by scalar type.
    'ContactSurface_',
    'FramePoseVector_',
    'PenetrationAsPointPair_',
    'QueryObject_',
    'SceneGraph_',
    'SceneGraphInspector_',
    'SignedDistancePair_',
    'SignedDistanceToPoint_',
    'Plane_',
    'PolygonSurfaceMesh_',
    'PolygonSurfaceMeshFieldLinear_',
    'SurfaceMesh_',
    'SurfaceVertex_',
    'TriangleSurfaceMesh_',
    'TriangleSurfaceMeshFieldLinear_',
    'VolumeMesh_',
    # Additions to pydrake: contexts, compiling, result sequences, levels of accuracy, details of
    # filters,
    'SceneGraphContext',
    'compile_all_kernels',
    'kernel_cache',
    'kernel_state',
    'PenetrationResults',
    'SignedDistanceResults',
    'PointDistanceResults',
    'ContactSurfaceResults',
    'MotionCheck',
    'ClosingSpeeds',
    'closing_speeds',
    'DrakeVisualizerPublisher',
    'Effects',
    'ACCURACY_LEVELS',
    'Accuracy',
    'AccuracyLike',
    'accuracy_of',
    'ACCURACY_GAPS',
    'METHODS',
    'ShapeKind',
    'OccupiedCells',
    'PointCloud',
    'HydroelasticType',
    'FilterGroup',
    'FilterOperation',
    'FilterStatement',
    # the exact renderer and the one by VTK,
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
    __getattr__ = refuse_missing(
        __name__,
        dict.fromkeys(
            ('Meshcat', 'MeshcatParams', 'StartMeshcat'), 'drake_geom_ros.viewing.meshcat'
        ),
    )
