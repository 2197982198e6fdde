"""A small scene that tests of the scene model share."""

from drake_geom_ros.geometry import (
    Box,
    FramePoseVector,
    GeometryFrame,
    GeometryInstance,
    HalfSpace,
    IllustrationProperties,
    ProximityProperties,
    SceneGraph,
    Sphere,
)
from drake_geom_ros.math import RigidTransform

# A file of a tetrahedron, as OBJ.
TETRAHEDRON = 'v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n'


def instance(name, shape=None, p=(0, 0, 0), proximity=True):
    """Return a geometry, with the proximity role unless it is not wanted."""
    made = GeometryInstance(RigidTransform(p), shape or Sphere(0.5), name)
    if proximity:
        made.set_proximity_properties(ProximityProperties())
    return made


class SmallScene:
    """Two sources; ``arm`` has frames ``upper`` and, on it, ``lower``, ``room`` a floor.

    On ``upper`` is ``ball``, on that ``knob``; on ``lower`` are ``box`` and the drawn ``label``.
    """

    def __init__(self):
        self.scene_graph = scene_graph = SceneGraph()
        self.arm = arm = scene_graph.RegisterSource('arm')
        self.room = scene_graph.RegisterSource('room')
        self.upper = scene_graph.RegisterFrame(arm, GeometryFrame('upper', 2))
        self.lower = scene_graph.RegisterFrame(arm, self.upper, GeometryFrame('lower'))
        ball, box = instance('ball', p=(0, 0, 1)), instance('box', Box(1, 1, 1))
        self.ball = scene_graph.RegisterGeometry(arm, self.upper, ball)
        self.knob = scene_graph.RegisterGeometry(arm, self.ball, instance('knob', p=(0, 0, 0.5)))
        self.box = scene_graph.RegisterGeometry(arm, self.lower, box)
        label = instance('label', Box(1, 1, 0.1), proximity=False)
        label.set_illustration_properties(IllustrationProperties())
        self.label = scene_graph.RegisterGeometry(arm, self.lower, label)
        floor = instance('floor', HalfSpace())
        self.floor = scene_graph.RegisterAnchoredGeometry(self.room, floor)
        self.geometries = [self.ball, self.knob, self.box, self.label, self.floor]

    def fix(self, context, **translations):
        """Pose the arm's frames by name."""
        poses = {getattr(self, name): RigidTransform(p) for name, p in translations.items()}
        port = self.scene_graph.get_source_pose_port(self.arm)
        port.FixValue(context, FramePoseVector(poses))

    def query_of(self, context):
        return self.scene_graph.get_query_output_port().Eval(context)
