"""What is drawn is what is checked: extents of shapes, ids, colours, pairs."""

import itertools
from types import SimpleNamespace as Plain

import numpy as np
import pytest
from oracles.solids import surface_of
from ros.live_scenes import Topic, live_scene

from drake_geom_ros.geometry import (
    Box,
    Capsule,
    Convex,
    Cylinder,
    Ellipsoid,
    FramePoseVector,
    GeometryId,
    GeometryInstance,
    HalfSpace,
    IllustrationProperties,
    Mesh,
    ProximityProperties,
    Rgba,
    Role,
    SceneGraph,
    Sphere,
)
from drake_geom_ros.math import RigidTransform, RollPitchYaw
from drake_geom_ros.ros.outputs import markers
from drake_geom_ros.ros.outputs.marker_publisher import MarkerPublisher
from drake_geom_ros.ros.scene.feeders import MESSAGES

TEXT = """
sources: [s]
frames:
  - {name: a, source: s, pose: {}}
  - {name: b, source: s, pose: {position: [1, 0, 0]}}
geometries:
  - {name: capsule, source: s, frame: a, shape: {type: capsule, radius: 0.1, length: 0.4}}
  - {name: ball, source: s, frame: b, shape: {type: sphere, radius: 0.1},
     roles: {proximity: {}, illustration: {phong: {diffuse: {rgba: [1, 0, 0, 0.5]}}}}}
  - {name: seen, source: s, frame: b, shape: {type: sphere, radius: 0.2},
     roles: {illustration: {}}}
"""


def vector(**numbers):
    return Plain(**{'x': 0.0, 'y': 0.0, 'z': 0.0, **numbers})


def new_marker(**fields):
    return Plain(
        **{'type': 0, 'ns': '', 'id': 0, 'action': 0, 'points': [], **fields},
        header=Plain(frame_id='', stamp=Plain(sec=0, nanosec=0)),
        pose=Plain(position=vector(), orientation=vector(w=0.0)),
        scale=vector(),
        color=Plain(r=0.0, g=0.0, b=0.0, a=0.0),
    )


TYPES = Plain(Marker=new_marker, MarkerArray=Plain, Point=vector)


class Publisher(Topic):
    """Keeps what RViz would show."""

    def __init__(self):
        super().__init__()
        self.shown = {}

    def publish(self, message):
        keys = [(m.ns, m.id) for m in message.markers]
        assert len(set(keys)) == len(keys), 'RViz refuses an array with an id twice'
        super().publish(message.markers)
        for marker in message.markers:
            if marker.action == markers.DELETE_ALL:
                self.shown.clear()
            elif marker.action == markers.DELETE:
                self.shown.pop((marker.ns, marker.id), None)
            else:
                self.shown[marker.ns, marker.id] = marker

    def names(self):
        return sorted(ns for ns, _ in self.shown)


@pytest.fixture
def live():
    return live_scene(TEXT, world_frame='map')


@pytest.fixture
def publisher():
    return Publisher()


@pytest.fixture
def drawing(live, publisher):
    return MarkerPublisher(live, publisher, TYPES, lambda: 2.0, lambda *_: None)


def extent(parts):
    """Return the highest point (3,) of markers along each axis of the geometry's frame."""
    tops = []
    for part in parts:
        p = part.X_GP.translation()
        if part.triangles is not None:
            tops.append((part.triangles @ part.X_GP.rotation().matrix().T + p).max(axis=0))
        else:
            tops.append(p + np.array(part.scale) / 2)
    return np.max(tops, axis=0)


@pytest.mark.parametrize(
    ('shape', 'expected'),
    [
        (Sphere(0.3), (0.3, 0.3, 0.3)),
        (Box(2, 4, 6), (1, 2, 3)),
        (Cylinder(0.5, 3), (0.5, 0.5, 1.5)),
        (Ellipsoid(1, 2, 3), (1, 2, 3)),
        (Capsule(0.5, 3), (0.5, 0.5, 2.0)),
    ],
)
def test_a_shape_is_as_large_as_what_is_checked(shape, expected):
    assert extent(markers.parts_of(shape)) == pytest.approx(expected)


def test_a_half_space_ends_at_its_plane():
    (plate,) = markers.parts_of(HalfSpace())
    assert extent([plate])[2] == pytest.approx(0.0)


def test_a_capsule_is_a_cylinder_between_two_balls():
    tube, *balls = markers.parts_of(Capsule(0.5, 3))
    assert (tube.kind, tube.scale) == (markers.CYLINDER, (1.0, 1.0, 3.0))
    assert [ball.kind for ball in balls] == [markers.SPHERE] * 2
    assert sorted(ball.X_GP.translation()[2] for ball in balls) == [-1.5, 1.5]


@pytest.mark.parametrize('kind', [Convex, Mesh])
@pytest.mark.parametrize('scale', [1.0, [2.0, 3.0, -4.0]])
def test_a_mesh_is_drawn_as_its_hull_seen_from_outside(tmp_path, kind, scale):
    corners = np.array(list(itertools.product((0.0, 1.0), repeat=3)))
    lines = [f'v {x} {y} {z}' for x, y, z in [*corners, (0.5, 0.5, 0.5)]]
    path = tmp_path / 'cube.obj'
    path.write_text('\n'.join([*lines, 'f 1 2 9', 'f 3 4 9', 'f 5 6 7 8']))
    (part,) = markers.parts_of(kind(str(path), scale))
    a, b, c = np.moveaxis(part.triangles.reshape(-1, 3, 3), 1, 0)
    normals = np.cross(b - a, c - a)
    # Outward triangles of a closed surface: the divergence theorem gives the volume.
    assert (a * normals).sum() / 6 == pytest.approx(np.prod(np.abs(np.broadcast_to(scale, 3))))


def test_a_solid_is_drawn_as_itself(monkeypatch):
    mesh = Mesh.FromMeshData(surface_of('L'), 0.5)
    hull, solid = (markers.parts_of(mesh, solid)[0].triangles for solid in (False, True))

    def volume(triangles):
        a, b, c = np.moveaxis(triangles.reshape(-1, 3, 3), 1, 0)
        return (a * np.cross(b, c)).sum() / 6

    assert volume(hull) == pytest.approx(3.5 / 8)
    assert volume(solid) == pytest.approx(3.0 / 8)
    monkeypatch.setattr(markers, 'MOST_DRAWN', 5)
    assert volume(markers.parts_of(mesh, True)[0].triangles) == pytest.approx(3.5 / 8)


@pytest.mark.parametrize('role', [Role.kProximity, Role.kIllustration])
def test_which_meshes_are_solid_is_a_matter_of_proximity(role):
    scene_graph = SceneGraph()
    source = scene_graph.RegisterSource('s')
    shape = Mesh.FromMeshData(surface_of('L'))
    found = []
    for solid in (True, False):
        geometry = scene_graph.RegisterAnchoredGeometry(
            source, GeometryInstance(RigidTransform(), shape, f'solid {solid}')
        )
        for properties in (ProximityProperties(), IllustrationProperties()):
            properties.AddProperty('mesh', 'solid', solid)
            scene_graph.AssignRole(source, geometry, properties)
        found.append(markers.is_solid(scene_graph.model_inspector(), geometry, role))
    assert found == [role is Role.kProximity, False]


def test_a_moving_scene_is_sent_once_and_then_what_moved(scene, publisher, drawing):
    drawing.publish()
    assert publisher.names() == [
        'distances',
        'illustration',
        'illustration',
        *['proximity'] * 4,
    ]
    capsule = [m for m in publisher.shown.values() if m.type == markers.CYLINDER]
    assert capsule[0].header.frame_id == 'map'
    assert capsule[0].pose.orientation.w == 1.0
    red = [m for m in publisher.shown.values() if m.color.r == 1.0]
    assert [m.color.a for m in red] == [0.5]
    drawing.publish()
    assert {m.ns for m in publisher.published[-1]} == {'distances', 'contacts', 'normals'}
    X_WB = RigidTransform(RollPitchYaw(0, 0, 1.0).ToRotationMatrix(), [0.15, 0, 0])
    move(scene, 'b', X_WB)
    drawing.publish()
    geometry = [m for m in publisher.published[-1] if m.ns in markers.NAMESPACES.values()]
    assert len(geometry) == 3
    assert {m.pose.position.x for m in geometry} == {0.15}
    # The ball now overlaps the capsule: witness points, a normal, and no distance.
    assert publisher.names().count('contacts') == 1
    assert 'distances' not in publisher.names()
    (contacts,) = [m for m in publisher.shown.values() if m.ns == 'contacts']
    assert sorted(p.x for p in contacts.points) == pytest.approx([0.05, 0.1])


def move(scene, frame, X_PF):
    scene._context.UpdateFramePoses(FramePoseVector({scene.names.frame(frame): X_PF}))


def test_who_comes_late_gets_everything(publisher, drawing):
    drawing.publish()
    whole = len(publisher.published[-1])
    publisher.listeners = 2
    drawing.publish()
    assert len(publisher.published[-1]) == whole


def test_nothing_is_drawn_for_nobody(publisher, drawing):
    publisher.listeners = 0
    drawing.publish()
    assert publisher.published == []


def test_what_is_removed_vanishes_and_ids_stay(scene, publisher, drawing):
    drawing.publish()
    before = {key for key, m in publisher.shown.items() if m.ns == 'proximity'}
    capsule = scene.names.geometry('a/capsule')
    source = scene.inspector.GetOwningSourceId(capsule)
    scene.scene_graph.ChangeShape(source, capsule, Sphere(0.1))
    drawing.publish()
    after = {key for key, m in publisher.shown.items() if m.ns == 'proximity'}
    assert after < before
    assert len(before - after) == 2
    scene.scene_graph.RemoveGeometry(source, capsule)
    drawing.publish()
    assert publisher.names().count('proximity') == 1
    drawing.clear()
    assert publisher.shown == {}


def test_colours_come_from_the_properties(scene):
    ball, seen = (scene.names.geometry(f'b/{name}') for name in ('ball', 'seen'))
    colours = [markers.colour_of(scene.inspector, id, Role.kIllustration) for id in (ball, seen)]
    assert colours[0] == (1.0, 0.0, 0.0, 0.5)
    assert Rgba(*colours[1]).a() == 1.0
    assert markers.colour_of(scene.inspector, ball, Role.kProximity)[3] < 1.0


def test_ids_of_any_geometry_fit_into_a_marker():
    writer = markers.MarkerWriter(TYPES, 'world', None)
    parts = markers.parts_of(Capsule(1, 1))
    drawn = writer.geometry('n', GeometryId(2**40), parts, (1, 1, 1, 1), RigidTransform())
    assert all(0 <= marker.id < 2**31 for marker in drawn)
    assert len({marker.id for marker in drawn}) == 3


def test_what_never_had_a_pose_is_not_drawn_until_it_has(publisher):
    live = live_scene(TEXT.replace('{name: a, source: s, pose: {}}', '{name: a, source: s}'))
    drawing = MarkerPublisher(live, publisher, TYPES, lambda: 2.0, lambda *_: None)

    drawing.publish()
    before = publisher.names()
    with live.editing() as scene:
        poses = FramePoseVector({scene.names.frame('a'): RigidTransform()})
        scene.pose(poses, {}, Plain(sec=0, nanosec=0), MESSAGES)
    drawing.publish()
    capsule = len(markers.parts_of(Capsule(0.1, 0.4)))
    assert publisher.names().count('proximity') == before.count('proximity') + capsule
    assert before.count('proximity') > 0
