"""Imports point inward: who may import what, as the table of the house says."""

import sys

import pytest
from conventions.source_tree import PACKAGE, SOURCES, imports_of, name_of

ROS_PREFIXES = ('rclpy', 'rosidl', 'ament', 'builtin_interfaces', 'rcl_interfaces', 'std_srvs')

# What the rooms of the node may import of ours beside one another, and of others beside NumPy.
_CORE = ('math', 'common', 'sensors', 'geometry', 'scene_files')
_HELD = (*_CORE, 'ros/conversions', 'ros/scene')
ROS_ROOMS = {
    'ros/conversions': ((*_CORE, 'ros/conversions'), ('numpy',)),
    'ros/scene': (_HELD, ('numpy',)),
    'ros/inputs': ((*_HELD, 'ros/inputs'), ('numpy',)),
    'ros/outputs': (
        (*_HELD, 'replay', 'cross_check', 'viewing', 'ros/outputs'),
        ('numpy', 'ROS'),
    ),
    'ros/services': ((*_HELD, 'ros/inputs', 'ros/services'), ('numpy', 'ROS')),
    'ros/viewer': (
        (*_CORE, 'client', 'viewing', 'viewing/page', 'ros/conversions', 'ros', 'ros/viewer'),
        ('numpy', 'ROS'),
    ),
    'ros/demo': (
        (*_CORE, 'trajectories', 'client', 'ros/conversions', 'ros', 'ros/demo'),
        ('numpy', 'matplotlib', 'mpl_toolkits', 'ROS'),
    ),
    'ros': (
        (
            *(*_HELD, 'trajectories', 'cross_check', 'ros/inputs', 'ros/outputs'),
            *('ros/services', 'ros'),
        ),
        ('numpy', 'ROS'),
    ),
}

# Room -> (rooms of ours, libraries of others) that its files may import. The longest room wins.
LAYERS = {
    '': (('command_line',), ()),
    'math': (('math',), ('numpy',)),
    'autodiffutils': (('math', 'autodiffutils'), ('numpy',)),
    'common': (('math', 'common'), ('numpy',)),
    'geometry/_proximity': (('math', 'geometry/_proximity'), ('numpy', 'numba', 'llvmlite')),
    'geometry/_rendering': (
        ('math', 'geometry/_proximity', 'geometry/_rendering'),
        ('numpy', 'numba'),
    ),
    'geometry': (
        (
            *('math', 'common', 'autodiffutils', 'sensors', 'geometry'),
            *('geometry/_proximity', 'geometry/_rendering', 'geometry/_vtk'),
        ),
        ('numpy',),
    ),
    'geometry/_vtk': (
        ('math', 'common', 'geometry', 'geometry/_vtk'),
        ('numpy', 'vtkmodules'),
    ),
    'sensors': (('math', 'sensors'), ('numpy',)),
    'scene_files': (
        ('math', 'common', 'sensors', 'geometry', 'scene_files'),
        ('numpy', 'yaml', 'lxml', 'jsonschema'),
    ),
    'trajectories': (
        ('math', 'geometry', 'scene_files', 'trajectories'),
        ('numpy', 'yaml', 'yourdfpy'),
    ),
    'batch': (
        ('math', 'common', 'geometry', 'scene_files', 'trajectories', 'batch'),
        ('numpy', 'distributed', 'matplotlib', 'pyarrow'),
    ),
    'replay': (('math', 'common', 'geometry', 'scene_files', 'replay'), ()),
    'cross_check': (
        ('math', 'geometry', 'replay', 'cross_check', 'evidence', 'evidence/peers'),
        ('numpy',),
    ),
    'evidence/peers': (
        ('math', 'geometry', 'evidence/peers'),
        ('numpy', 'pydrake', 'fcl', 'coal', 'mujoco'),
    ),
    'evidence': (
        ('math', 'common', 'geometry', 'evidence', 'evidence/peers'),
        ('numpy', 'scipy', 'mpmath', 'matplotlib'),
    ),
    'evidence/hunt': (
        ('math', 'geometry', 'evidence', 'evidence/hunt'),
        ('numpy', 'numba', 'scipy'),
    ),
    # What is shown, without a library that shows it; and the page, which one draws.
    'viewing': (
        ('math', 'common', 'geometry', 'scene_files', 'trajectories', 'viewing'),
        ('numpy', 'yaml'),
    ),
    'viewing/page': (
        ('math', 'common', 'geometry', 'trajectories', 'viewing', 'viewing/page'),
        ('numpy', 'viser', 'websockets', 'imageio'),
    ),
    'command_line': (
        (
            *('math', 'common', 'sensors', 'geometry', 'scene_files', 'trajectories', 'replay'),
            *('command_line', 'batch', 'evidence', 'evidence/peers', 'cross_check'),
            *('viewing', 'viewing/page'),
        ),
        ('numpy', 'PIL', 'matplotlib'),
    ),
    # What asks a node is no part of it.
    'client': (('math', 'common', 'client'), ('numpy', 'ROS')),
    **ROS_ROOMS,
}
# One file for what nobody else may touch.
EXCEPTIONS = {
    'geometry/_mesh_library.py': 'trimesh',
    'geometry/drake_visualizer.py': 'lcm',
}


def room_of(path):
    """Return the innermost room of the table that holds a path relative to the package."""
    rooms = [room for room in LAYERS if not room or f'{path}/'.startswith(f'{room}/')]
    return max(rooms, key=len)


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


@pytest.mark.parametrize('path', SOURCES, ids=name_of)
def test_a_file_imports_only_what_its_room_may(path):
    assert forbidden(str(path.relative_to(PACKAGE)), path.read_text()) == []


@pytest.mark.parametrize('path', SOURCES, ids=name_of)
def test_private_modules_stay_within_their_room(path):
    room = room_of(str(path.relative_to(PACKAGE))).split('/')[0]
    names = [name for name in imports_of(path.read_text()) if name.startswith('drake_geom_ros.')]
    outside = [name for name in names if name.split('.')[1] != room]
    assert [name for name in outside if '._' in name] == []


@pytest.mark.parametrize(
    ('path', 'source', 'culprit'),
    [
        ('math/batched.py', 'import scipy', 'scipy'),
        ('math/batched.py', 'def f():\n    import rclpy', 'rclpy'),
        ('math/batched.py', 'from drake_geom_ros.geometry import Sphere', 'geometry'),
        ('geometry/_proximity/engine.py', 'from drake_geom_ros.geometry import ids', 'ids'),
        ('geometry/_proximity/engine.py', 'import fcl', 'fcl'),
        ('geometry/shapes.py', 'from . import ids', 'relative'),
        ('geometry/shapes.py', 'from std_msgs.msg import Header', 'std_msgs'),
        ('scene_files/urdf.py', 'import drake_geom_ros.geometry._proximity.world', 'world'),
        ('sensors/images.py', 'from drake_geom_ros.geometry import Sphere', 'geometry'),
        ('geometry/_rendering/drawing.py', 'import drake_geom_ros.geometry.ids', 'ids'),
        (
            'ros/outputs/cycle.py',
            'from drake_geom_ros.geometry._proximity import engine',
            'engine',
        ),
        ('ros/scene/live_scene.py', 'from std_msgs.msg import Header', 'std_msgs'),
        ('client/services.py', 'from drake_geom_ros.ros import surface', 'surface'),
        ('client/results.py', 'from drake_geom_ros.geometry import Sphere', 'geometry'),
        ('ros/inputs/tf_input.py', 'from drake_geom_ros.ros import surface', 'surface'),
        ('ros/scene_graph_node.py', 'from drake_geom_ros.ros.demo import client', 'demo'),
        (
            'ros/outputs/cycle.py',
            'from drake_geom_ros.evidence.truth import convex',
            'evidence',
        ),
        ('evidence/laws.py', 'import drake_geom_ros.geometry._proximity.promise', 'promise'),
    ],
)
def test_a_forbidden_import_is_seen(path, source, culprit):
    (found,) = forbidden(path, source)
    assert culprit in found


def test_only_the_command_line_and_the_second_opinion_ask_for_evidence():
    asking = {
        room for room, (ours, _) in LAYERS.items() if any('evidence' in each for each in ours)
    }
    assert asking == {
        *('evidence', 'evidence/hunt', 'evidence/peers'),
        *('command_line', 'cross_check'),
    }


def test_the_exception_is_allowed():
    assert forbidden('geometry/_mesh_library.py', 'import trimesh') == []
