"""What a change calls for is loaded and compiled before the scene's lock is taken; without ROS."""

import threading
import time
from types import SimpleNamespace as Plain

import numpy as np
import pytest
from live.live_scenes import live_scene
from oracles.small_scene import TETRAHEDRON

from drake_geom_ros.geometry import SceneGraph, ShapeKind
from drake_geom_ros.geometry._proximity.kernels import addresses as kernel_table
from drake_geom_ros.geometry.meshes import source as mesh_source
from drake_geom_ros.live.conversions.file_access import FileAccess
from drake_geom_ros.live.guard import Guard
from drake_geom_ros.live.inputs.robot_description import RobotInput
from drake_geom_ros.live.services import files, shapes

ANSWER = Guard(logger=None, count=None).answer
TEXT = """
sources: [s]
frames: [{name: a, source: s}, {name: b, source: s}]
geometries:
  - {name: ball, source: s, frame: a, shape: {type: sphere, radius: 0.1}}
  - {name: seen, source: s, frame: b, shape: {type: cylinder, radius: 0.1, length: 0.2},
     roles: {illustration: {}}}
"""
SPHERE, BOX, CONVEX = ShapeKind.SPHERE, ShapeKind.BOX, ShapeKind.CONVEX
ROBOT = (
    '<robot name="r"><link name="l"><collision><geometry><box size="1 1 1"/></geometry>'
    '</collision></link></robot>'
)


@pytest.fixture
def live(tmp_path):
    live = live_scene(TEXT)
    live.files = FileAccess([str(tmp_path)])
    live.compile_kernels()
    return live


@pytest.fixture
def mesh(tmp_path):
    """Return the path of a tetrahedron that nobody has read yet: a file is known by content."""
    path = tmp_path / 'tetrahedron.obj'
    path.write_text(f'# {time.monotonic_ns()}\n' + TETRAHEDRON)
    return str(path)


def shape(kind, dimensions=(), mesh_uri=''):
    fields = {'vertices': [], 'triangles': [], 'mesh_uri': mesh_uri}
    return Plain(type=kind, dimensions=list(dimensions), **fields)


def role(number):
    return Plain(role=number, properties=[])


def registration(shape, name='new', roles=(1,)):
    position, orientation = Plain(x=0.0, y=0.0, z=0.5), Plain(x=0.0, y=0.0, z=0.0, w=1.0)
    return Plain(
        source='s',
        frame='a',
        parent_geometry='',
        name=name,
        pose=Plain(position=position, orientation=orientation),
        shape=shape,
        roles=[role(number) for number in roles],
    )


def call(handler, live, request):
    response = ANSWER(handler, live, request, Plain())
    assert response.success, response.message
    return response


def is_free(lock):
    """Tell whether another thread could take the lock now."""
    taken = []

    def take():
        if lock.acquire(blocking=False):
            taken.append(True)
            lock.release()

    thread = threading.Thread(target=take)
    thread.start()
    thread.join()
    return bool(taken)


@pytest.fixture
def watched(live, monkeypatch):
    """Return the list of (what took long, whether the lock was free then)."""
    events = []
    compile_kernel, parse_mesh = kernel_table.compiled_address, mesh_source.parse_mesh

    def compiling(kernel):
        events.append((kernel.__name__, is_free(live._lock)))
        return compile_kernel(kernel)

    def loading(*args, **kwargs):
        events.append(('load', is_free(live._lock)))
        return parse_mesh(*args, **kwargs)

    spheres = np.zeros_like(kernel_table.COMPILED_ROWS)
    spheres[0] = True  # as if the process had only compiled what the live scene called for
    monkeypatch.setattr(kernel_table, 'COMPILED_ROWS', spheres)
    monkeypatch.setattr(kernel_table, 'compiled_address', compiling)
    monkeypatch.setattr(mesh_source, 'parse_mesh', loading)
    return events


BOXES = """
sources: [t]
frames: [{name: f, source: t}]
geometries: [{name: g, source: t, %sshape: {type: box, size: [1, 1, 1]}}]
"""


def loading(text, **fields):
    return Plain(path='', text=text, format='', srdf='', **fields)


def requests(mesh):
    """Return by name: handler, request, and what it calls for."""
    register, change = shapes.register_geometry, shapes.change_shape
    reshape = Plain(geometry='a/ball', shape=shape(BOX, (1.0, 1.0, 1.0)))
    cores = 'signed_distance_of_cores'
    return {
        'register a box': (
            *(register, registration(shape(BOX, (1.0, 1.0, 1.0)))),
            {'sphere_box', 'box_box'},
        ),
        'register a mesh': (
            *(register, registration(shape(CONVEX, mesh_uri=mesh))),
            {'load', cores},
        ),
        'change a shape': (change, reshape, {'box_box'}),
        'assign a role': (
            shapes.assign_role,
            Plain(geometry='b/seen', assign=0, role=role(1)),
            {'sphere_cylinder', cores},
        ),
        'load a scene': (
            *(files.load_scene, loading(BOXES % '', replace=False, replaced_sources=[])),
            {'sphere_box'},
        ),
        'replace the scene': (
            *(files.load_scene, loading(BOXES % 'frame: f, ', replace=True, replaced_sources=[])),
            {'box_box'},
        ),
    }


CASES = sorted(requests(''))


def query(live):
    """Run a cycle's query as the stream does; return the effects."""
    with live.editing() as scene:
        scene.query.ComputeSignedDistancePairwiseClosestPoints(10.0)
        return scene.query.effects()


def version(live):
    with live.reading() as scene:
        return scene.model.version


@pytest.mark.clock
@pytest.mark.parametrize('case', CASES)
def test_what_takes_long_is_done_while_the_lock_is_free(live, watched, mesh, case):
    handler, request, wanted = requests(mesh)[case]
    before = version(live)
    call(handler, live, request)
    assert version(live) > before
    assert {name for name, _ in watched} == wanted
    assert all(free for _, free in watched)
    # Nothing is left for the next cycle.
    watched.clear()
    effects = query(live)
    assert effects.kernels_compiled == watched == []


@pytest.mark.clock
def test_a_robot_is_made_ready_while_the_lock_is_free(live, watched):
    robot = RobotInput(live)
    for text in (ROBOT, ROBOT.replace('box size="1 1 1"', 'cylinder radius="1" length="1"')):
        robot.take(text)
        assert all(free for _, free in watched)
        assert query(live).kernels_compiled == []
    assert {'sphere_box', 'sphere_cylinder'} <= {name for name, _ in watched}


@pytest.mark.clock
@pytest.mark.parametrize('roles', [(), (2,)])
def test_what_no_query_sees_calls_for_nothing(live, watched, mesh, roles):
    request = registration(shape(CONVEX, mesh_uri=mesh), roles=roles)
    call(shapes.register_geometry, live, request)
    assert watched == []


def test_another_of_a_kind_that_is_there_is_not_made_ready(live, monkeypatch):
    monkeypatch.setattr(live, 'make_ready', None)
    request = registration(shape(SPHERE, (0.2,)))
    call(shapes.register_geometry, live, request)
    assert query(live).kernels_compiled == []


@pytest.mark.clock
def test_many_are_registered_while_the_lock_is_free(live, monkeypatch):
    register, was_free = SceneGraph.RegisterGeometry, []

    def registering(*args, **fields):
        was_free.append(is_free(live._lock))
        return register(*args, **fields)

    monkeypatch.setattr(SceneGraph, 'RegisterGeometry', registering)
    balls = [registration(shape(SPHERE, (0.2,)), f'new{k}') for k in range(1001)]
    answer = call(shapes.register_geometries, live, Plain(source='s', geometries=balls))
    assert len(answer.geometry_ids) == len(was_free) == 1001
    assert all(was_free)


@pytest.mark.clock
def test_cycles_run_while_a_mesh_is_read(live, watched, mesh, monkeypatch):
    """The reading waits until a number of cycles has run, and would wait for ever."""
    reading, enough = threading.Event(), threading.Event()
    parse_mesh = mesh_source.parse_mesh

    def slow(*args, **kwargs):
        reading.set()
        assert enough.wait(60.0)
        return parse_mesh(*args, **kwargs)

    monkeypatch.setattr(mesh_source, 'parse_mesh', slow)
    request = registration(shape(CONVEX, mesh_uri=mesh))
    thread = threading.Thread(
        target=call, args=(shapes.register_geometry, live, request), daemon=True
    )
    thread.start()
    assert reading.wait(60.0)
    before = version(live)
    for _ in range(100):
        query(live)
        assert live.view().query.HasCollisions() is False
    assert version(live) == before
    enough.set()
    thread.join(60.0)
    assert live.view().names.geometry('a/new') is not None


def test_what_the_copy_refuses_changes_nothing(live, mesh, tmp_path):
    flat = tmp_path / 'flat.obj'
    flat.write_text('v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n')
    before = version(live)
    request = registration(shape(CONVEX, mesh_uri=str(flat)))
    response = ANSWER(shapes.register_geometry, live, request, Plain())
    assert not response.success
    assert 'plane' in response.message
    assert version(live) == before
    taken = registration(shape(BOX, (1.0, 1.0, 1.0)), name='ball')
    response = ANSWER(shapes.register_geometry, live, taken, Plain())
    assert not response.success
    assert version(live) == before
