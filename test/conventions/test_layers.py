"""Imports point inward: who may import what, as the table of the house says, and in no circle."""

import sys
from graphlib import CycleError, TopologicalSorter

import pytest
from conventions.layers import EXCEPTIONS, LAYERS, room_of
from conventions.source_tree import PACKAGE, SOURCES, TRUTH, imports_of, module_of, name_of
from every import report

ROS_PREFIXES = ('rclpy', 'rosidl', 'ament', 'builtin_interfaces', 'rcl_interfaces', 'std_srvs')


def is_ros(library):
    return library.startswith(ROS_PREFIXES) or library.endswith('_msgs')


def forbidden(path, source):
    """Return what a file imports against the table; `path` is relative to the package."""
    ours, libraries = LAYERS[room_of(path)]
    found = []
    for name in imports_of(source):
        library = name.split('.')[0]
        if name.startswith('.'):
            found.append(f'{name} (relative)')
        elif library == 'drake_geom_ros':
            target = '/'.join(name.split('.')[1:])
            if room_of(target) not in ours:
                found.append(name)
        elif library not in sys.stdlib_module_names:
            allowed = library in libraries or ('ROS' in libraries and is_ros(library))
            if not allowed and EXCEPTIONS.get(path) != library:
                found.append(name)
    return found


def test_a_file_imports_only_what_its_room_may():
    report(
        f'{name_of(path)}: {name}'
        for path in SOURCES
        for name in forbidden(str(path.relative_to(PACKAGE)), path.read_text())
    )


def private_of_other_rooms(path, source):
    """Return the private modules of other rooms that a file imports."""
    room = room_of(path).split('/')[0]
    names = [name for name in imports_of(source) if name.startswith('drake_geom_ros.')]
    return [name for name in names if name.split('.')[1] != room and '._' in name]


def test_private_modules_stay_within_their_room():
    report(
        f'{name_of(path)}: {name}'
        for path in SOURCES
        for name in private_of_other_rooms(str(path.relative_to(PACKAGE)), path.read_text())
    )


def test_a_private_module_of_another_room_is_seen():
    name = 'drake_geom_ros.geometry._proximity.kinds.Method'
    source = 'from drake_geom_ros.geometry._proximity.kinds import Method'
    assert private_of_other_rooms('ros/cycle.py', source) == [name]
    assert private_of_other_rooms('geometry/queries/context.py', source) == []


@pytest.mark.parametrize(
    ('path', 'source', 'culprit'),
    [
        ('math/batched.py', 'import scipy', 'scipy'),
        ('math/batched.py', 'def f():\n    import rclpy', 'rclpy'),
        ('math/batched.py', 'from drake_geom_ros.geometry import Sphere', 'geometry'),
        ('geometry/_proximity/engine/engine.py', 'from drake_geom_ros.geometry import ids', 'ids'),
        ('geometry/_proximity/engine/engine.py', 'import fcl', 'fcl'),
        ('geometry/shapes/primitives.py', 'from . import ids', 'relative'),
        ('geometry/shapes/primitives.py', 'from std_msgs.msg import Header', 'std_msgs'),
        ('scene_files/urdf.py', 'import drake_geom_ros.geometry._proximity.world.world', 'world'),
        ('sensors/images.py', 'from drake_geom_ros.geometry import Sphere', 'geometry'),
        ('geometry/_rendering/drawing.py', 'import drake_geom_ros.geometry.ids', 'ids'),
        (
            'live/outputs/cycle.py',
            'from drake_geom_ros.geometry._proximity.engine import engine',
            'engine',
        ),
        ('live/scene/live_scene.py', 'from std_msgs.msg import Header', 'std_msgs'),
        ('client/services.py', 'from drake_geom_ros.ros import surface', 'surface'),
        ('client/results.py', 'from drake_geom_ros.geometry import Sphere', 'geometry'),
        ('live/inputs/tf_input.py', 'from drake_geom_ros.ros import surface', 'surface'),
        ('ros/scene_graph_node.py', 'from drake_geom_ros.ros.demo import client', 'demo'),
        ('live/outputs/cycle.py', 'from bench.peers import report', 'bench'),
        (
            'cross_check/judging.py',
            'import drake_geom_ros.geometry._proximity.pairs.error_bounds',
            'error_bounds',
        ),
        (
            'geometry/_proximity/near/making.py',
            'from drake_geom_ros.geometry._proximity.pairs import narrow_phase',
            'narrow_phase',
        ),
        ('geometry/model/_model.py', 'import drake_geom_ros.geometry.queries.context', 'context'),
    ],
)
def test_a_forbidden_import_is_seen(path, source, culprit):
    (found,) = forbidden(path, source)
    assert culprit in found


def beside_the_truth(source):
    """Return what a source imports that would judge us by ourselves: kernels, tests, bench."""
    rooms = {'bench', 'oracles', 'conventions', 'pytest'}
    names = imports_of(source)
    return [name for name in names if name.split('.')[0] in rooms or '_proximity' in name]


def test_truth_imports_no_kernel_no_test_and_no_measurement():
    report(
        f'{name_of(path)}: {name}' for path in TRUTH for name in beside_the_truth(path.read_text())
    )


def test_truth_by_a_kernel_is_seen():
    kernel = 'drake_geom_ros.geometry._proximity.kernels.vectors'
    source = f'import numpy\nimport {kernel}\nfrom bench.peers import report\nimport oracles'
    assert beside_the_truth(source) == [kernel, 'bench.peers.report', 'oracles']


def test_the_exception_is_allowed():
    assert forbidden('geometry/meshes/_library.py', 'import trimesh') == []


def imports_by_file(paths):
    """Return the modules of ours that each module imports, wherever in it and for types too."""
    modules = {module_of(path): path.read_text() for path in paths}
    graph = {}
    for module, source in modules.items():
        found = set()
        for name in imports_of(source):
            while name not in modules and '.' in name:
                name = name.rpartition('.')[0]
            found.add(name)
        graph[module] = found & set(modules) - {module}
    return graph


def circle(graph):
    """Return the nodes of a circle, an empty list where there is none."""
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as error:
        return error.args[1]
    return []


def test_no_file_imports_itself_by_way_of_others():
    assert circle(imports_by_file(SOURCES)) == []


def test_no_room_imports_itself_by_way_of_others():
    paths = {module_of(path): str(path.relative_to(PACKAGE)) for path in SOURCES}
    rooms = {}
    for module, found in imports_by_file(SOURCES).items():
        room = room_of(paths[module])
        rooms.setdefault(room, set()).update({room_of(paths[name]) for name in found} - {room})
    assert circle(rooms) == []


def test_a_circle_is_seen():
    assert circle({'a': {'b'}, 'b': {'c'}, 'c': {'a'}})
    assert circle({'a': {'b', 'c'}, 'b': {'c'}}) == []
