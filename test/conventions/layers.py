"""The rooms of the house from the ground up: what each may import of ours, and of others."""

_K = 'geometry/_proximity/kernels'
_RUNTIME = 'geometry/_proximity/runtime'
_GROUND = ('math', 'geometry/_proximity', _RUNTIME)
_SHAPES = (*_GROUND, _K, f'{_K}/shapes')
_CALLING = (*_SHAPES, f'{_K}/calling')
_CORES = (*_CALLING, f'{_K}/closed_forms', f'{_K}/cores')
_WORLD = (*_SHAPES, 'geometry/_proximity/world')
_NEAR = (*_WORLD, 'geometry/_proximity/filters', 'geometry/_proximity/near')
_REPORT = (*_WORLD, f'{_K}/addresses', 'geometry/_proximity/report')
_PAIRS = (*_NEAR, *_REPORT, f'{_K}/calling', 'geometry/_proximity/pairs')
_POINTS = (*_PAIRS, 'geometry/_proximity/points')

# One question each (docs/contributing.md), and imports only downwards.
PROXIMITY_ROOMS = {
    'geometry/_proximity': (('math', 'geometry/_proximity'), ()),
    _RUNTIME: ((*_GROUND, f'{_RUNTIME}/numba_inside'), ('numpy', 'numba', 'llvmlite')),
    f'{_RUNTIME}/numba_inside': (
        (f'{_RUNTIME}/numba_inside',),
        ('numpy', 'numba', 'llvmlite'),
    ),
    'geometry/_proximity/filters': (
        (*_GROUND, 'common', 'geometry/_proximity/filters'),
        ('numpy',),
    ),
    _K: ((*_GROUND, _K), ('numpy',)),
    f'{_K}/shapes': (_SHAPES, ('numpy', 'numba', 'llvmlite')),
    f'{_K}/trees': ((*_SHAPES, f'{_K}/trees'), ('numpy',)),
    f'{_K}/calling': (_CALLING, ('numpy', 'numba')),
    f'{_K}/addresses': ((*_CALLING, f'{_K}/addresses'), ('numpy',)),
    f'{_K}/closed_forms': ((*_CALLING, f'{_K}/closed_forms'), ('numpy',)),
    f'{_K}/cores': (_CORES, ('numpy',)),
    f'{_K}/revolution': ((*_CORES, f'{_K}/revolution'), ('numpy',)),
    f'{_K}/solids': (
        (*_CORES, f'{_K}/trees', f'{_K}/solids'),
        ('numpy', 'numba', 'llvmlite'),
    ),
    f'{_K}/sensed': ((*_CALLING, f'{_K}/trees', f'{_K}/sensed'), ('numpy', 'numba')),
    f'{_K}/convex': ((*_CORES, f'{_K}/revolution', f'{_K}/convex'), ('numpy',)),
    'geometry/_proximity/world': (_WORLD, ('numpy', 'numba')),
    'geometry/_proximity/near': ((*_NEAR, f'{_K}/calling'), ('numpy', 'numba', 'llvmlite')),
    'geometry/_proximity/report': (_REPORT, ('numpy',)),
    'geometry/_proximity/pairs': (_PAIRS, ('numpy',)),
    'geometry/_proximity/points': (_POINTS, ('numpy', 'numba')),
    'geometry/_proximity/derivatives': (
        (*_PAIRS, f'{_K}/solids', 'geometry/_proximity/derivatives'),
        ('numpy',),
    ),
    'geometry/_proximity/states': ((*_POINTS, 'geometry/_proximity/states'), ('numpy',)),
    'geometry/_proximity/motion': (
        (*_POINTS, 'geometry/_proximity/states', 'geometry/_proximity/motion'),
        ('numpy',),
    ),
    'geometry/_proximity/engine': (
        (*_POINTS, 'geometry/_proximity/derivatives', 'geometry/_proximity/engine'),
        ('numpy', 'numba'),
    ),
    'geometry/_contact_surfaces': (
        (*_GROUND, _K, f'{_K}/solids', 'geometry/_contact_surfaces'),
        ('numpy', 'numba'),
    ),
    'geometry/_joint_gradients': (
        (
            *(*_PAIRS, 'geometry/_proximity/derivatives', 'geometry/_proximity/states'),
            'geometry/_joint_gradients',
        ),
        ('numpy',),
    ),
    'geometry/_stops': (
        (*_POINTS, 'geometry/_proximity/motion', 'geometry/_stops'),
        ('numpy',),
    ),
    'geometry/_rendering': ((*_GROUND, 'geometry/_rendering'), ('numpy', 'numba')),
}

# Compiled by those who ask.
_APART = (
    *('geometry/_rendering', 'geometry/_contact_surfaces', 'geometry/_joint_gradients'),
    'geometry/_stops',
)
_ANSWERING = tuple(room for room in PROXIMITY_ROOMS if room not in _APART)
_MESHES = ('math', 'common', 'geometry', 'geometry/meshes')
_PUBLIC_SHAPES = (*_MESHES, 'geometry/shapes')
_HYDROELASTIC = (*_PUBLIC_SHAPES, 'geometry/hydroelastic')
_MODEL = (*_HYDROELASTIC, 'geometry/model')
_RENDER = (*_MODEL, 'sensors', 'geometry/render')
_QUERIES = (*_RENDER, 'geometry/queries')
_SCENE = (*_QUERIES, 'autodiffutils', 'geometry/scene')

GEOMETRY_ROOMS = {
    'geometry': (('math', 'geometry', 'geometry/_proximity/runtime'), ('numpy',)),
    'geometry/meshes': (
        (*_MESHES, *_SHAPES, f'{_K}/trees', f'{_K}/solids'),
        ('numpy',),
    ),
    'geometry/shapes': (
        (*_PUBLIC_SHAPES, *_SHAPES, f'{_K}/trees', f'{_K}/sensed'),
        ('numpy',),
    ),
    'geometry/hydroelastic': (_HYDROELASTIC, ('numpy',)),
    'geometry/model': ((*_MODEL, *_WORLD, 'geometry/_proximity/filters'), ('numpy',)),
    'geometry/render': ((*_RENDER, *_WORLD, 'geometry/_rendering'), ('numpy',)),
    'geometry/render/vtk': (
        (*_MODEL, 'sensors', 'geometry/render', 'geometry/render/vtk'),
        ('numpy', 'vtkmodules'),
    ),
    'geometry/queries': (
        (
            *(*_QUERIES, *_ANSWERING, 'geometry/_contact_surfaces', 'geometry/_joint_gradients'),
            'geometry/_stops',
        ),
        ('numpy',),
    ),
    'geometry/scene': ((*_SCENE, *_ANSWERING), ('numpy',)),
    'geometry/autodiff': ((*_SCENE, *_ANSWERING, 'geometry/autodiff'), ('numpy',)),
    'geometry/visualizer': ((*_SCENE, 'geometry/visualizer'), ('numpy',)),
    # What users import: names of all rooms, and nothing else.
    'geometry/__init__': (
        (
            *(*_SCENE, *_ANSWERING, 'geometry/render/vtk', 'geometry/autodiff'),
            'geometry/visualizer',
        ),
        (),
    ),
}

# What the rooms of the node may import of ours beside one another, and of others beside NumPy.
_CORE = (
    *('math', 'common', 'sensors', 'geometry', 'proximity_rules', 'sensed_maps'),
    *('stopping', 'scene_files'),
)
_HELD = (*_CORE, 'geometry/queries', 'live/conversions', 'live/scene')
_LIVE = (*_HELD, 'live/inputs', 'live/outputs', 'live')
# What a node keeps and does. Nothing here imports ROS.
LIVE_ROOMS = {
    'live/conversions': ((*_CORE, 'geometry/queries', 'live/conversions'), ('numpy',)),
    'live/scene': ((*_HELD, 'geometry/render', 'trajectories'), ('numpy',)),
    'live/inputs': ((*_HELD, 'live/inputs'), ('numpy',)),
    'live/outputs': (
        (*_HELD, 'geometry/visualizer', 'replay', 'cross_check', 'viewing', 'live/outputs'),
        ('numpy',),
    ),
    'live/services': (
        (*_HELD, 'batch', 'trajectories', 'live/inputs', 'live/services'),
        ('numpy',),
    ),
    'live/watching': (
        (*_HELD, 'batch', 'trajectories', 'live/outputs', 'live/services', 'live/watching'),
        ('numpy',),
    ),
    'live': (_LIVE, ('numpy',)),
}
# What rclpy sees.
ROS_ROOMS = {
    'ros/outputs': (
        (*_HELD, 'geometry/render', 'live/outputs', 'ros/outputs'),
        ('numpy', 'ROS'),
    ),
    'ros/services': (
        (*_HELD, 'live/services', 'live/watching', 'ros/services'),
        ('numpy', 'ROS'),
    ),
    'ros/sensing': ((*_LIVE, 'ros/sensing'), ('numpy', 'ROS')),
    'ros/viewer': (
        (*_CORE, 'client', 'viewing', 'viewing/page', 'live/conversions', 'ros', 'ros/viewer'),
        ('numpy', 'ROS'),
    ),
    # What a user's own node would do, shown.
    'ros/demo': (
        (
            *('math', 'common', 'sensors', 'geometry', 'scene_files', 'trajectories', 'client'),
            *('viewing', 'live/conversions', 'program_parser', 'ros', 'ros/demo'),
        ),
        ('numpy', 'matplotlib', 'ROS'),
    ),
    'ros/recorder': (
        ('common', 'scene_files', 'program_parser', 'ros', 'ros/recorder'),
        ('ROS', 'rosbags'),
    ),
    'ros/status': (
        ('common', 'client', 'program_parser', 'ros/sensing', 'ros', 'ros/status'),
        ('ROS',),
    ),
    'ros': (
        (
            *(*_LIVE, 'trajectories', 'cross_check', 'live/services', 'live/watching'),
            *('ros/outputs', 'ros/services', 'ros/sensing', 'ros'),
        ),
        ('numpy', 'ROS'),
    ),
}

# Room -> (rooms of ours, libraries of others) that its files may import. The longest room wins.
LAYERS = {
    '': (('programs', 'version'), ()),
    'version': ((), ()),
    'program_parser': (('common',), ()),
    'every_kernel': (('geometry', 'proximity_rules', 'sensed_maps'), ()),
    # What is started, each of which imports the rest of itself.
    'programs': (
        ('command_line', 'ros', 'ros/demo', 'ros/recorder', 'ros/viewer', 'ros/status'),
        (),
    ),
    'math': (('math',), ('numpy',)),
    'autodiffutils': (('math', 'autodiffutils'), ('numpy',)),
    'common': (('math', 'common'), ('numpy', 'pandas', 'tqdm')),
    'sensors': (('math', 'sensors'), ('numpy',)),
    'stopping': (('math', 'common', 'geometry', 'geometry/queries', 'stopping'), ('numpy',)),
    'proximity_rules': (
        ('math', 'common', 'geometry', 'stopping', 'proximity_rules'),
        ('numpy',),
    ),
    **PROXIMITY_ROOMS,
    **GEOMETRY_ROOMS,
    'sensed_maps': (('math', 'common', 'geometry', 'geometry/meshes', 'sensed_maps'), ('numpy',)),
    'scene_files': (
        (
            *('math', 'common', 'sensors', 'geometry', 'geometry/shapes', 'geometry/queries'),
            *('proximity_rules', 'sensed_maps', 'scene_files'),
        ),
        ('numpy', 'yaml', 'lxml', 'jsonschema', 'jsonschema_rs', 'xacro', 'mujoco'),
    ),
    'trajectories': (
        (
            *('math', 'autodiffutils', 'common', 'geometry', 'geometry/queries', 'scene_files'),
            'trajectories',
        ),
        ('numpy', 'yaml'),
    ),
    'batch': (
        ('math', 'common', 'geometry', 'geometry/queries', 'scene_files', 'trajectories', 'batch'),
        ('numpy', 'distributed', 'matplotlib', 'nrrd', 'openvdb', 'pyarrow', 'pyopenvdb'),
    ),
    # Constraints and gradients for solvers.
    'optimization': (
        ('math', 'autodiffutils', 'common', 'geometry', 'batch', 'trajectories', 'optimization'),
        ('numpy', 'scipy', 'casadi', 'cyipopt'),
    ),
    'replay': (
        ('math', 'common', 'geometry', 'proximity_rules', 'scene_files', 'replay'),
        ('numpy', 'yaml'),
    ),
    'cross_check': (
        ('math', 'common', 'geometry', 'sensed_maps', 'replay', 'cross_check'),
        ('numpy', 'scipy', 'fcl'),
    ),
    # What is shown, without a library that shows it; and the page, which one draws.
    'viewing': (
        (
            'math',
            'common',
            'sensors',
            'geometry',
            'geometry/queries',
            'proximity_rules',
            'scene_files',
            'trajectories',
            'viewing',
        ),
        ('numpy', 'scipy', 'yaml', 'PIL'),
    ),
    'viewing/page': (
        ('math', 'common', 'geometry', 'trajectories', 'viewing', 'viewing/page'),
        ('numpy', 'viser', 'imageio', 'websockets', 'trimesh', 'PIL'),
    ),
    'viewing/meshcat': (
        ('math', 'common', 'geometry', 'viewing', 'viewing/page', 'viewing/meshcat'),
        ('numpy',),
    ),
    'recordings': (
        (
            *_HELD,
            *('live/inputs', 'batch', 'replay', 'viewing', 'recordings'),
        ),
        ('numpy', 'yaml', 'rosbags', 'mcap', 'lz4', 'zstandard', 'matplotlib', 'PIL'),
    ),
    'command_line': (
        (
            *('math', 'common', 'sensors', 'geometry', 'geometry/shapes', 'geometry/queries'),
            *('scene_files', 'trajectories', 'replay', 'command_line', 'batch', 'cross_check'),
            *('viewing', 'viewing/page', 'recordings', 'sensed_maps', 'version'),
            'program_parser',
        ),
        ('numpy', 'PIL', 'matplotlib'),
    ),
    # What asks a node is no part of it.
    'client': (('math', 'common', 'client'), ('numpy', 'ROS')),
    **LIVE_ROOMS,
    **ROS_ROOMS,
}
# One file for what nobody else may touch.
EXCEPTIONS = {
    'geometry/meshes/_library.py': 'trimesh',
    'geometry/meshes/_by_trimesh.py': 'trimesh',
    'geometry/meshes/_coarse_hulls.py': 'scipy',  # the hulls of a few vertices, by Qhull
    'geometry/meshes/_oriented_hull.py': 'scipy',  # the hulls of meshes, by Qhull
    'geometry/meshes/_vtk_file.py': 'meshio',
    'geometry/visualizer/drake_visualizer.py': 'lcm',
    'scene_files/sdf_heightmaps.py': 'PIL',
}


def room_of(path):
    """Return the innermost room of the table that holds a path relative to the package."""
    path = path.removesuffix('.py')
    rooms = [room for room in LAYERS if not room or f'{path}/'.startswith(f'{room}/')]
    return max(rooms, key=len)
