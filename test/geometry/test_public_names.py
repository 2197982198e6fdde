"""The public names are those of CORE_API.md: no more, no less, and all of them there."""

import typing

import pytest

import drake_geom_ros.geometry
import drake_geom_ros.math
from drake_geom_ros.autodiffutils import AutoDiffXd

# CORE_API.md, "What must be there", in its order.
PYDRAKES = """
    Sphere Box Capsule Cylinder Ellipsoid HalfSpace Convex Mesh Shape
    SourceId FrameId GeometryId FilterId
    GeometryFrame GeometryInstance
    GeometryProperties ProximityProperties IllustrationProperties PerceptionProperties
    Rgba Role RoleAssign MakePhongIllustrationProperties AddContactMaterial
    GeometrySet FramePoseVector
    SceneGraph SceneGraphInspector GeometryVersion
    CollisionFilterManager CollisionFilterDeclaration CollisionFilterScope
    QueryObject PenetrationAsPointPair SignedDistancePair SignedDistanceToPoint
    SurfaceMesh SurfaceVertex SurfaceFace ReadObjToSurfaceMesh
    TriangleSurfaceMesh SurfaceTriangle ReadObjToTriangleSurfaceMesh
    PolygonSurfaceMesh SurfacePolygon Plane Obb Aabb CalcObb CalcVolume
    MeshcatCone InMemoryMesh MeshSource ComputeAabbForTriangleMesh ComputeObbForTriangleMesh
    FramePoseVector_ PenetrationAsPointPair_ QueryObject_ SceneGraph_ SceneGraphInspector_
    SignedDistancePair_ SignedDistanceToPoint_ SurfaceMesh_ SurfaceVertex_
    Plane_ PolygonSurfaceMesh_ TriangleSurfaceMesh_
    ContactSurface_ PolygonSurfaceMeshFieldLinear_ TriangleSurfaceMeshFieldLinear_
    ColorRenderCamera DepthRenderCamera RenderCameraCore ClippingRange DepthRange
    RenderLabel RenderEngine
    ConnectDrakeVisualizer DispatchLoadMessage
    AddRigidHydroelasticProperties AddCompliantHydroelasticProperties
    AddCompliantHydroelasticPropertiesForHalfSpace SceneGraphConfig DefaultProximityProperties
    ContactSurface HydroelasticContactRepresentation
    PolygonSurfaceMeshFieldLinear TriangleSurfaceMeshFieldLinear
    VolumeMesh VolumeMesh_ VolumeElement ConvertVolumeToSurfaceMesh RefineVolumeMesh
    RefineVolumeMeshIntoVtkFileContents ComputeAabbForVolumeMesh ComputeObbForVolumeMesh
"""
# What is ours: a context can be named, results are sequences, errors are a tree, and the rest.
OURS = """
    SceneGraphContext PenetrationResults SignedDistanceResults PointDistanceResults
    CandidatePairs MotionCheck ClosingSpeeds closing_speeds
    Accuracy AccuracyLike accuracy_of ACCURACY_LEVELS ACCURACY_GAPS Effects METHODS
    ShapeKind FilterGroup MeshData
    CoulombFriction HeightField FilterOperation FilterStatement HydroelasticType
    ContactSurfaceResults OccupiedCells PointCloud
    GeometryError ArgumentError ArgumentTypeError UnknownIdError OwnershipError DuplicateError
    RoleError PoseError FilterError MeshFileError
    compile_all_kernels kernel_cache kernel_state DrakeVisualizerPublisher
    MakeRenderEngineExact RenderEngineExact RenderEngineExactParams RenderedImages
    MakeRenderEngineVtk RenderEngineVtk RenderEngineVtkParams
"""


def test_geometry():
    names = drake_geom_ros.geometry.__all__
    assert sorted(names) == sorted([*PYDRAKES.split(), *OURS.split()])
    assert len(set(names)) == len(names)


MATH = """
    RigidTransform RigidTransform_ RollPitchYaw RollPitchYaw_ RotationMatrix RotationMatrix_
    ScalarTemplate
    abs acos arccos arcsin arctan arctan2 asin atan atan2 ceil cos cosh exp floor isnan log max min
    pow sin sinh sqrt tan tanh
"""


def test_math():
    assert sorted(drake_geom_ros.math.__all__) == MATH.split()


@pytest.mark.parametrize('module', [drake_geom_ros.geometry, drake_geom_ros.math])
def test_templates_have_their_scalar_types(module):
    names = [name for name in module.__all__ if name.endswith('_')]
    assert len(names) in (3, 16)
    for name in names:
        if 'Field' in name:
            continue  # of two types: see test/math/test_scalar_templates.py
        template = getattr(module, name)
        assert template[float] is getattr(module, name[:-1])
        assert repr(template) == name
        with pytest.raises(RuntimeError, match=rf'there is {name}\[float\].* only'):
            template[complex]
        if any(word in name for word in ('Mesh', 'Vertex', 'Plane', 'ContactSurface')):
            with pytest.raises(RuntimeError, match=r'\[float\] only'):
                template[AutoDiffXd]
        else:
            assert template[AutoDiffXd].__name__ == f'{name[:-1]}AutoDiffXd'


def test_every_name_exists_and_says_what_it_is():
    for module in (drake_geom_ros.geometry, drake_geom_ros.math):
        for name in module.__all__:
            thing = getattr(module, name)
            is_alias = typing.get_origin(thing) is not None
            assert not callable(thing) or is_alias or thing.__doc__, name
