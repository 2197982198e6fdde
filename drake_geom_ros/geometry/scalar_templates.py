"""The templates of pydrake.geometry, each with the one scalar type that there is."""

from drake_geom_ros.geometry.frame_pose_vector import FramePoseVector
from drake_geom_ros.geometry.query_object import QueryObject
from drake_geom_ros.geometry.query_results import (
    PenetrationAsPointPair,
    SignedDistancePair,
    SignedDistanceToPoint,
)
from drake_geom_ros.geometry.scene_graph import SceneGraph
from drake_geom_ros.geometry.scene_graph_inspector import SceneGraphInspector
from drake_geom_ros.geometry.surface_mesh import SurfaceMesh, SurfaceVertex
from drake_geom_ros.math import ScalarTemplate

FramePoseVector_ = ScalarTemplate(FramePoseVector)
PenetrationAsPointPair_ = ScalarTemplate(PenetrationAsPointPair)
QueryObject_ = ScalarTemplate(QueryObject)
SceneGraph_ = ScalarTemplate(SceneGraph)
SceneGraphInspector_ = ScalarTemplate(SceneGraphInspector)
SignedDistancePair_ = ScalarTemplate(SignedDistancePair)
SignedDistanceToPoint_ = ScalarTemplate(SignedDistanceToPoint)
SurfaceMesh_ = ScalarTemplate(SurfaceMesh)
SurfaceVertex_ = ScalarTemplate(SurfaceVertex)
