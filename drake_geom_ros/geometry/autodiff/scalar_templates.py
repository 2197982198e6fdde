"""The class templates of pydrake.geometry, for floats and, where needed, for AutoDiffXd."""

from drake_geom_ros.autodiffutils import AutoDiffXd
from drake_geom_ros.geometry.autodiff.context import SceneGraphInspectorAutoDiffXd
from drake_geom_ros.geometry.autodiff.poses import FramePoseVectorAutoDiffXd
from drake_geom_ros.geometry.autodiff.query_object import QueryObjectAutoDiffXd
from drake_geom_ros.geometry.autodiff.records import (
    PenetrationAsPointPairAutoDiffXd,
    SignedDistancePairAutoDiffXd,
    SignedDistanceToPointAutoDiffXd,
)
from drake_geom_ros.geometry.autodiff.scene_graph import SceneGraphAutoDiffXd
from drake_geom_ros.geometry.meshes.polygon_mesh import PolygonSurfaceMesh
from drake_geom_ros.geometry.meshes.surface_fields import (
    PolygonSurfaceMeshFieldLinear,
    TriangleSurfaceMeshFieldLinear,
)
from drake_geom_ros.geometry.meshes.surface_mesh import (
    SurfaceMesh,
    SurfaceVertex,
    TriangleSurfaceMesh,
)
from drake_geom_ros.geometry.meshes.volume_mesh import VolumeMesh
from drake_geom_ros.geometry.model.frame_pose_vector import FramePoseVector
from drake_geom_ros.geometry.model.scene_graph_inspector import SceneGraphInspector
from drake_geom_ros.geometry.queries.contact_surfaces import ContactSurface
from drake_geom_ros.geometry.queries.query_object import QueryObject
from drake_geom_ros.geometry.queries.query_records import (
    PenetrationAsPointPair,
    SignedDistancePair,
    SignedDistanceToPoint,
)
from drake_geom_ros.geometry.scene.scene_graph import SceneGraph_
from drake_geom_ros.geometry.shapes.plane import Plane
from drake_geom_ros.math import ScalarTemplate

ContactSurface_ = ScalarTemplate(ContactSurface)
FramePoseVector_ = ScalarTemplate(FramePoseVector)
PenetrationAsPointPair_ = ScalarTemplate(PenetrationAsPointPair)
Plane_ = ScalarTemplate(Plane)
PolygonSurfaceMesh_ = ScalarTemplate(PolygonSurfaceMesh)
PolygonSurfaceMeshFieldLinear_ = ScalarTemplate(PolygonSurfaceMeshFieldLinear, parameters=2)
QueryObject_ = ScalarTemplate(QueryObject)
SceneGraphInspector_ = ScalarTemplate(SceneGraphInspector)
SignedDistancePair_ = ScalarTemplate(SignedDistancePair)
SignedDistanceToPoint_ = ScalarTemplate(SignedDistanceToPoint)
SurfaceMesh_ = ScalarTemplate(SurfaceMesh)
SurfaceVertex_ = ScalarTemplate(SurfaceVertex)
TriangleSurfaceMesh_ = ScalarTemplate(TriangleSurfaceMesh)
TriangleSurfaceMeshFieldLinear_ = ScalarTemplate(TriangleSurfaceMeshFieldLinear, parameters=2)
VolumeMesh_ = ScalarTemplate(VolumeMesh)

FramePoseVector_.add(AutoDiffXd, FramePoseVectorAutoDiffXd)
PenetrationAsPointPair_.add(AutoDiffXd, PenetrationAsPointPairAutoDiffXd)
QueryObject_.add(AutoDiffXd, QueryObjectAutoDiffXd)
SceneGraph_.add(AutoDiffXd, SceneGraphAutoDiffXd)
SceneGraphInspector_.add(AutoDiffXd, SceneGraphInspectorAutoDiffXd)
SignedDistancePair_.add(AutoDiffXd, SignedDistancePairAutoDiffXd)
SignedDistanceToPoint_.add(AutoDiffXd, SignedDistanceToPointAutoDiffXd)
