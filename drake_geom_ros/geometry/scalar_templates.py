"""The templates of pydrake.geometry, each with the one scalar type that there is."""

from drake_geom_ros.geometry.frame_pose_vector import FramePoseVector
from drake_geom_ros.geometry.plane import Plane
from drake_geom_ros.geometry.polygon_mesh import PolygonSurfaceMesh
from drake_geom_ros.geometry.query_object import QueryObject
from drake_geom_ros.geometry.query_records import (
    PenetrationAsPointPair,
    SignedDistancePair,
    SignedDistanceToPoint,
)
from drake_geom_ros.geometry.scene_graph import SceneGraph
from drake_geom_ros.geometry.scene_graph_inspector import SceneGraphInspector
from drake_geom_ros.geometry.surface_mesh import SurfaceMesh, SurfaceVertex, TriangleSurfaceMesh
from drake_geom_ros.math import ScalarTemplate

FramePoseVector_ = ScalarTemplate(FramePoseVector)
PenetrationAsPointPair_ = ScalarTemplate(PenetrationAsPointPair)
Plane_ = ScalarTemplate(Plane)
PolygonSurfaceMesh_ = ScalarTemplate(PolygonSurfaceMesh)
QueryObject_ = ScalarTemplate(QueryObject)
SceneGraph_ = ScalarTemplate(SceneGraph)
SceneGraphInspector_ = ScalarTemplate(SceneGraphInspector)
SignedDistancePair_ = ScalarTemplate(SignedDistancePair)
SignedDistanceToPoint_ = ScalarTemplate(SignedDistanceToPoint)
SurfaceMesh_ = ScalarTemplate(SurfaceMesh)
SurfaceVertex_ = ScalarTemplate(SurfaceVertex)
TriangleSurfaceMesh_ = ScalarTemplate(TriangleSurfaceMesh)
