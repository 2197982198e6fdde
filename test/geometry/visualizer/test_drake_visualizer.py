"""Messages to Drake's visualiser: decoded by LCM's own classes, heard by its library."""

import os
import sys
import time
import warnings

import numpy as np
import pytest
from geometry.lcm_definitions import TYPES, generated
from oracles.mesh_files import glb, gltf
from oracles.solids import surface_of

from drake_geom_ros.geometry import (
    Box,
    Capsule,
    ConnectDrakeVisualizer,
    Convex,
    Cylinder,
    DispatchLoadMessage,
    Ellipsoid,
    FramePoseVector,
    GeometryError,
    GeometryFrame,
    GeometryInstance,
    HalfSpace,
    IllustrationProperties,
    MakePhongIllustrationProperties,
    Mesh,
    MeshData,
    ProximityProperties,
    Role,
    SceneGraph,
    Sphere,
)
from drake_geom_ros.geometry.visualizer import _messages as _visualizer_messages
from drake_geom_ros.geometry.visualizer import drake_visualizer
from drake_geom_ros.math import RigidTransform, RollPitchYaw

# Of Drake's lcmt_viewer_*, as its own classes give them (pydrake 1.51).
FINGERPRINTS = {
    'viewer_geometry_data': '5d2e34cb3257db07',
    'viewer_link_data': '51252725af982a63',
    'viewer_load_robot': '8987209b10aa2d39',
    'viewer_draw': '414f0bfe5b2f4244',
}
SHAPES = [Box(1, 2, 3), Sphere(0.5), Cylinder(0.1, 2), Capsule(0.2, 3), Ellipsoid(1, 2, 3)]
X_FG = RigidTransform(RollPitchYaw(0.1, 0.2, 0.3), [1.0, 2.0, 3.0])


class Wire:
    """Keeps what is published."""

    def __init__(self):
        self.sent = []

    def publish(self, channel, data):
        self.sent.append((channel, data))

    def of(self, channel):
        return [data for each, data in self.sent if each == channel]


@pytest.fixture(scope='module')
def classes(tmp_path_factory):
    return generated(tmp_path_factory.mktemp('lcm'))


def scene_of(*shapes, properties=None):
    """Return a scene with shapes on a frame, its frame, and a context."""
    scene = SceneGraph()
    source = scene.RegisterSource('robot')
    frame = scene.RegisterFrame(source, GeometryFrame('link', 7))
    for number, shape in enumerate(shapes):
        instance = GeometryInstance(X_FG, shape, f'shape {number}')
        instance.set_illustration_properties(properties or IllustrationProperties())
        scene.RegisterGeometry(source, frame, instance)
    floor = GeometryInstance(RigidTransform(), HalfSpace(), 'floor')
    floor.set_illustration_properties(MakePhongIllustrationProperties([0.1, 0.2, 0.3, 0.4]))
    scene.RegisterAnchoredGeometry(source, floor)
    context = scene.CreateDefaultContext()
    context.UpdateFramePoses(FramePoseVector({frame: X_FG}))
    return scene, frame, context


def loaded(scene, classes, role=Role.kIllustration):
    wire = Wire()
    DispatchLoadMessage(scene, wire, role)
    (message,) = wire.of('DRAKE_VIEWER_LOAD_ROBOT')
    return classes.viewer_load_robot.decode(message)


def test_fingerprints_are_those_of_lcm_gen(classes):
    for kind in TYPES:
        made = getattr(classes, kind.name)._get_packed_fingerprint()
        assert int.from_bytes(made, 'big') == kind.fingerprint, kind.name


@pytest.mark.parametrize('kind', TYPES, ids=lambda kind: kind.name)
def test_fingerprints_are_drakes(kind):
    assert f'{kind.fingerprint:016x}' == FINGERPRINTS[kind.name]


def test_fingerprints_are_those_of_the_installed_drake():
    drake = pytest.importorskip('drake', reason="Drake's own classes")
    for kind in TYPES:
        theirs = getattr(drake, f'lcmt_{kind.name}')._get_packed_fingerprint()
        assert int.from_bytes(theirs, 'big') == kind.fingerprint


def test_the_load_message_has_every_shape(classes):
    message = loaded(scene_of(*SHAPES)[0], classes)
    world, link = message.link
    assert (world.name, world.robot_num, world.num_geom) == ('world', 0, 1)
    assert (link.name, link.robot_num, link.num_geom) == ('robot::link', 7, 5)
    assert [(g.type, list(g.float_data)) for g in link.geom] == [
        (1, [1, 2, 3]),
        (2, [0.5]),
        (3, pytest.approx([0.1, 2])),
        (5, pytest.approx([0.2, 3])),
        (6, [1, 2, 3]),
    ]
    w, x, y, z = link.geom[0].quaternion
    assert [x, y, z, w] == pytest.approx(X_FG.ToArray()[3:].tolist())
    assert link.geom[0].position == pytest.approx([1, 2, 3])
    assert link.geom[0].color == pytest.approx([0.9, 0.9, 0.9, 1.0])
    (floor,) = world.geom
    assert floor.color == pytest.approx([0.1, 0.2, 0.3, 0.4])
    # A box whose top is the plane.
    assert floor.type == 1
    assert floor.position[2] + floor.float_data[2] / 2 == 0.0


def test_only_geometry_of_the_role_is_sent(classes):
    scene, _, _ = scene_of(Sphere(1.0))
    message = loaded(scene, classes, Role.kProximity)
    assert [(link.name, link.num_geom) for link in message.link] == [('world', 0)]


def triangles_of(data):
    count = int(data[0])
    vertices = np.reshape(data[2 : 2 + 3 * count], (-1, 3))
    return vertices[np.reshape(data[2 + 3 * count :], (-1, 3)).astype(int)]


def volume(triangles):
    a, b, c = np.moveaxis(np.asarray(triangles), 1, 0)
    return (a * np.cross(b, c)).sum() / 6


def test_meshes_go_by_file_where_it_is_there_and_else_inline(classes, tmp_path):
    path = tmp_path / 'cube.obj'
    path.write_text('v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n')
    shapes = (
        *(Mesh(str(path), [1, 2, 3]), Mesh.FromMeshData(surface_of('L')), Convex(str(path), 2)),
        Convex.FromMeshData(surface_of('L')),
    )
    _, link = loaded(scene_of(*shapes)[0], classes).link
    by_file, solid, tetrahedron, hull = link.geom
    assert {g.type for g in link.geom} == {4}
    assert (by_file.string_data, list(by_file.float_data)) == (str(path), [1, 2, 3])
    for inline, expected in ((solid, 3.0), (tetrahedron, 8 / 6), (hull, 3.5)):
        assert inline.string_data == ''
        assert volume(triangles_of(inline.float_data)) == pytest.approx(expected)


def test_gltf_goes_by_its_file_which_drake_turns_and_glb_turned(classes, tmp_path):
    (tmp_path / 'box.gltf').write_text(gltf())
    (tmp_path / 'box.glb').write_bytes(glb())
    shapes = [Mesh(str(tmp_path / name), [1, 2, 3]) for name in ('box.gltf', 'box.glb')]
    _, link = loaded(scene_of(*shapes)[0], classes).link
    by_file, inline = link.geom
    assert (by_file.string_data, list(by_file.float_data)) == (shapes[0].filename(), [1, 2, 3])
    found = triangles_of(inline.float_data)
    assert found.min(axis=(0, 1)).tolist() == [0, -6, 0]
    assert found.max(axis=(0, 1)).tolist() == [1, 0, 6]


def test_a_mesh_is_what_queries_take_it_for(classes):
    scene = SceneGraph()
    source = scene.RegisterSource('s')
    for solid in (False, True):
        instance = GeometryInstance(
            RigidTransform(), Mesh.FromMeshData(surface_of('L')), f'{solid}'
        )
        properties = ProximityProperties()
        properties.AddProperty('mesh', 'solid', solid)
        instance.set_proximity_properties(properties)
        scene.RegisterAnchoredGeometry(source, instance)
    (world,) = loaded(scene, classes, Role.kProximity).link
    found = [volume(triangles_of(g.float_data)) for g in world.geom]
    assert found == pytest.approx([3.5, 3.0])


def test_what_cannot_be_drawn_is_told_and_left_out(classes):
    with pytest.warns(UserWarning, match='/nowhere/at_all.stl'):
        message = loaded(scene_of(Mesh('/nowhere/at_all.stl'), Sphere(1))[0], classes)
    assert message.link[1].num_geom == 1


def grid(n):
    """Return a surface of 2 n^2 triangles over a square of 1 m, and below it one corner."""
    rows, columns = np.divmod(np.arange((n + 1) ** 2), n + 1)
    vertices = np.stack([rows / n, columns / n, np.zeros(len(rows))], axis=1)
    k = np.arange(n * n) // n * (n + 1) + np.arange(n * n) % n
    triangles = np.concatenate(
        [np.stack([k, k + n + 1, k + 1], 1), np.stack([k + n + 2, k + 1, k + n + 1], 1)]
    )
    vertices = np.vstack([vertices, [0.5, 0.5, -1.0]])
    return MeshData(vertices, np.vstack([triangles, [0, n, len(vertices) - 1]]))


def test_a_message_that_would_be_lost_has_boxes_for_its_largest_meshes(classes):
    scene, _, _ = scene_of(Mesh.FromMeshData(grid(20)), Mesh.FromMeshData(grid(100)))
    wire = Wire()
    with pytest.warns(UserWarning, match='shape 1 is drawn as a box'):
        DispatchLoadMessage(scene, wire)
    ((_, data),) = wire.sent
    assert len(data) < 180_000
    small, large = classes.viewer_load_robot.decode(data).link[1].geom
    assert (small.type, large.type) == (4, 1)
    assert np.prod(large.float_data) == pytest.approx(1.0)


def test_a_message_that_is_too_large_all_the_same_is_told(monkeypatch):
    monkeypatch.setattr(_visualizer_messages, 'MOST_BYTES', 1000)
    scene, _, _ = scene_of(*[Sphere(1.0)] * 30)
    with pytest.warns(UserWarning, match='receive buffer'):
        DispatchLoadMessage(scene, Wire())


def test_draws_are_due_60_times_a_second_and_after_one_load(classes):
    _, frame, context = scene_of(Sphere(1.0))
    wire = Wire()
    visualizer = ConnectDrakeVisualizer(None, scene_of(Sphere(1.0))[0], wire)
    assert [visualizer.Publish(context, k / 240) for k in range(9)] == [
        k % 4 == 0 for k in range(9)
    ]
    assert [channel for channel, _ in wire.sent] == [
        'DRAKE_VIEWER_LOAD_ROBOT',
        *['DRAKE_VIEWER_DRAW'] * 3,
    ]
    X_WF = RigidTransform(RollPitchYaw(1.0, 0.5, -0.5), [7.0, 8.0, 9.0])
    context.UpdateFramePoses(FramePoseVector({frame: X_WF}))
    visualizer.set_publish_period(0.0)
    assert visualizer.Publish(context, 0.0625)
    draw = classes.viewer_draw.decode(wire.sent[-1][1])
    assert (draw.timestamp, draw.num_links) == (62, 1)
    assert (list(draw.link_name), list(draw.robot_num)) == (['robot::link'], [7])
    assert draw.position[0] == pytest.approx([7, 8, 9])
    w, x, y, z = draw.quaternion[0]
    assert [x, y, z, w] == pytest.approx(X_WF.ToArray()[3:].tolist())


def test_a_change_of_geometry_and_a_new_beginning_load_again():
    scene, _, context = scene_of(Sphere(1.0))
    wire = Wire()
    visualizer = ConnectDrakeVisualizer(None, scene, lcm=wire)
    visualizer.Publish(context, 0.0)
    visualizer.Publish(context, 1.0)
    assert len(wire.of('DRAKE_VIEWER_LOAD_ROBOT')) == 1
    visualizer.Publish(context, 0.0)
    assert len(wire.of('DRAKE_VIEWER_LOAD_ROBOT')) == 2
    inspector = context_inspector(scene, context)
    (link,) = [g for g in inspector.GetAllGeometryIds() if inspector.GetName(g) == 'shape 0']
    source = inspector.GetOwningSourceId(link)
    scene.RemoveRole(context, source, link, Role.kIllustration)
    visualizer.Publish(context, 2.0)
    assert len(wire.of('DRAKE_VIEWER_LOAD_ROBOT')) == 3


def context_inspector(scene, context):
    return scene.get_query_output_port().Eval(context).inspector()


def test_many_links_are_drawn_by_several_messages(classes, monkeypatch):
    monkeypatch.setattr(_visualizer_messages, 'MOST_BYTES', 1000)
    scene = SceneGraph()
    source = scene.RegisterSource('s')
    poses = FramePoseVector()
    for k in range(30):
        frame = scene.RegisterFrame(source, GeometryFrame(f'a frame with a long name {k}'))
        instance = GeometryInstance(RigidTransform(), Sphere(1.0), 'ball')
        instance.set_illustration_properties(IllustrationProperties())
        scene.RegisterGeometry(source, frame, instance)
        poses.set_value(frame, RigidTransform([k, 0.0, 0.0]))
    context = scene.CreateDefaultContext()
    context.UpdateFramePoses(poses)
    wire = Wire()
    with warnings.catch_warnings():
        warnings.simplefilter('ignore')
        ConnectDrakeVisualizer(None, scene, wire).Publish(context, 0.0)
    draws = wire.of('DRAKE_VIEWER_DRAW')
    assert len(draws) > 1
    assert max(map(len, draws)) < 1000
    found = [classes.viewer_draw.decode(data) for data in draws]
    assert [p[0] for draw in found for p in draw.position] == list(range(30))


def test_the_pose_bundle_has_the_frames_of_the_picture():
    scene, _, context = scene_of(Sphere(1.0))
    port = scene.get_pose_bundle_output_port()
    bundle = port.Eval(context)
    assert bundle.get_num_poses() == 1
    assert (bundle.get_name(0), bundle.get_model_instance_id(0)) == ('robot::link', 7)
    assert bundle.get_transform(0).IsExactlyEqualTo(X_FG)
    wire = Wire()
    assert ConnectDrakeVisualizer(None, scene, port, wire).Publish(context, 0.0)


def test_what_means_nothing_here_is_refused_with_a_reason(monkeypatch):
    scene, _, _ = scene_of()
    with pytest.raises(GeometryError, match='no systems framework'):
        ConnectDrakeVisualizer(object(), scene, Wire())
    with pytest.raises(RuntimeError, match='period'):
        ConnectDrakeVisualizer(None, scene, Wire()).set_publish_period(-1.0)
    with pytest.raises(RuntimeError, match='too many'):
        ConnectDrakeVisualizer(None, scene, Wire(), Role.kProximity, 1)
    monkeypatch.setitem(sys.modules, 'lcm', None)
    with pytest.raises(GeometryError, match="extra 'lcm'"):
        ConnectDrakeVisualizer(None, scene)


def test_a_listener_of_the_library_hears_it(classes):
    lcm = pytest.importorskip('lcm', reason='the library')
    url = f'udpm://239.255.76.67:{20000 + os.getpid() % 20000}?ttl=0'
    try:
        wire, ear = drake_visualizer.open_lcm(url), lcm.LCM(url)
    except (GeometryError, RuntimeError) as error:
        pytest.skip(f'there is no multicast here: {error}')
    heard = []
    for channel in ('DRAKE_VIEWER_LOAD_ROBOT', 'DRAKE_VIEWER_DRAW'):
        ear.subscribe(channel, lambda channel, data: heard.append((channel, data)))
    scene, _, context = scene_of(*SHAPES)
    visualizer = ConnectDrakeVisualizer(None, scene, wire)
    end = time.monotonic() + 60.0
    moment = 0.0
    while len({channel for channel, _ in heard}) < 2 and time.monotonic() < end:
        visualizer.Publish(context, moment)
        ear.handle_timeout(100)
        moment += 1.0
    messages = dict(heard)
    load = classes.viewer_load_robot.decode(messages['DRAKE_VIEWER_LOAD_ROBOT'])
    assert load.link[1].num_geom == len(SHAPES)
    assert classes.viewer_draw.decode(messages['DRAKE_VIEWER_DRAW']).num_links == 1


def test_a_network_that_cannot_be_used_is_told():
    pytest.importorskip('lcm', reason='the library')
    with pytest.raises(GeometryError, match='LCM cannot be opened at nonsense://'):
        drake_visualizer.open_lcm('nonsense://')
