import runpy
from pathlib import Path

from setuptools import find_packages, setup

NAME = 'drake_geom_ros'
SHARE = f'share/{NAME}'
VERSION = runpy.run_path(f'{NAME}/version.py')['VERSION']

# What the core and the command line import. The lower bounds are the oldest versions that the
# tests of the core were seen to pass with. Only Numba is bound from above: what a later version of
# another breaks nobody knows yet. What is tested every day is pinned in requirements/.
CORE = [
    'jsonschema>=4.10',  # scene files against their schema
    'jsonschema-rs>=0.26',  # whether they are valid, soon
    'lxml>=4.9',  # URDF and SRDF
    # The kernels. With one that was not tested they would compile for three times as long, and
    # what a wheel brings of them would not be used.
    'numba>=0.58,<0.69',
    'numpy>=1.26',
    'pyyaml>=6.0',  # scene files
    'scipy>=1.11',  # hulls, asked for by trimesh
    'tqdm>=4.62',  # progress of what takes long
    'trimesh>=4.6',  # mesh files; the first that reads scenes of all formats
]
# What a node takes of ROS 2, for those without a distribution: an extra for each that PyPI has.
# The messages are of this version, compiled for that distribution.
ROS_FROM_PYPI = {
    distribution: [
        f'drake-geom-msgs-{distribution}=={VERSION}',
        *(
            f'ros-{distribution}-{name}'
            for name in (
                'rclpy[fastrtps]',
                'diagnostic-msgs',
                'geometry-msgs',
                'lifecycle-msgs',
                'rcl-interfaces',
                'sensor-msgs',
                'std-srvs',
                'trajectory-msgs',
                'visualization-msgs',
            )
        ),
    ]
    for distribution in ('kilted', 'jazzy')
}
EXTRAS = {
    'xacro': ['xacro>=2.1'],  # robots written with macros: *.xacro
    'cluster': ['distributed>=2024.1'],  # batches of states on a cluster
    'parquet': ['pyarrow>=14.0'],  # and their results as Parquet
    'cross_check': ['python-fcl>=0.7.0.5'],  # a second opinion
    'pictures': ['matplotlib>=3.6', 'pillow>=10.1'],  # what `render` and the demo write
    # reports of what ROS recorded; lz4 and zstandard are what mcap needs for compressed chunks
    'recordings': ['lz4>=4', 'mcap>=1.3', 'rosbags>=0.11', 'zstandard>=0.22'],
    'volume_meshes': ['meshio>=5.3'],  # tetrahedra in .vtk files
    'view': ['imageio>=2.20', 'viser>=1.1', 'websockets>=14'],  # the page
    'vtk': ['vtk>=9.5'],  # images with textures and glTF materials
    'completion': ['shtab>=1.6'],  # of the shell
    'lcm': ['lcm>=1.5'],  # messages to Drake's visualiser
    'dataframes': ['pandas>=2.0'],  # results as tables
    'nrrd': ['pynrrd>=1.0'],  # fields of distances for volume viewers
    'casadi': ['casadi>=3.6'],  # constraints as functions of CasADi
    'mujoco': ['mujoco>=3.17'],  # models of MuJoCo (MJCF)
}
# Models in all formats: macros, MJCF, tetrahedra, images of height maps, and mesh files of several
# parts, which trimesh joins.
EXTRAS['models'] = [
    *EXTRAS['xacro'],
    *EXTRAS['volume_meshes'],
    *EXTRAS['mujoco'],
    'networkx>=3.0',
    'pillow>=10.1',
]
EXTRAS['all'] = sorted({name for names in EXTRAS.values() for name in names})
# Problems of IPOPT. cyipopt itself has to be compiled, and Ipopt installed before; of this one
# there are wheels for Linux only, so it is not among `all`.
EXTRAS['ipopt'] = ['cyipopt-wheels>=1.7.0.dev0']
# The robot of the demo weighs more than all the rest.
EXTRAS['demo'] = [*EXTRAS['pictures'], 'example-robot-data>=4.3']
EXTRAS['examples'] = ['ompl>=2.0', 'ruckig>=0.15']  # the examples that plan
EXTRAS |= ROS_FROM_PYPI
# The tests of the core; those whose library is missing, such as pydrake, are skipped.
EXTRAS['test'] = [
    *(
        name
        for extra in ('cross_check', 'pictures', 'volume_meshes', 'xacro')
        for name in EXTRAS[extra]
    ),
    'example-robot-data>=4.3',  # the robots of scenes
    'hypothesis>=6.100',  # laws
    'manifold3d>=2.3',  # a second opinion on volumes
    'markdown-it-py>=3.0',  # the code blocks of the documentation
    'mkdocs>=1.5',  # the documentation as a site
    'mpmath>=1.3',  # references in high precision
    'networkx>=3.0',  # scenes of several meshes, read by trimesh
    'packaging>=23.0',  # the ranges of this file
    'pytest>=8.2',
    'pytest-timeout>=2.3',
    'pytest-xdist>=3.5',
    'shtab>=1.6',  # completion of the shell
    'yourdfpy>=0.0.56',  # a second opinion on forward kinematics
]


def shared(folder):
    """List the files of a folder for the share of the package, where launch looks for them."""
    return (f'{SHARE}/{folder}', sorted(str(path) for path in Path(folder).glob('*.*')))


setup(
    name=NAME,
    version=VERSION,
    description='Geometry service for ROS 2: signed distances, penetrations, collision filters.',
    long_description=Path('README.md').read_text(encoding='utf-8'),
    long_description_content_type='text/markdown',
    license='Apache-2.0',
    maintainer='drake_geom_ros maintainers',
    maintainer_email='maintainers@drake-geom-ros.invalid',
    python_requires='>=3.10,<3.14',  # those that are tested
    packages=find_packages(include=[NAME, f'{NAME}.*']),
    # Kernels are there in a tree that `./run wheels` builds from.
    package_data={
        NAME: [
            'py.typed',
            '*/*.schema.json',
            'viewing/page/static/*',
            '_kernels/*/*.kernel',
            '_kernels/*/*/*.kernel',
        ]
    },
    data_files=[
        ('share/ament_index/resource_index/packages', [f'resource/{NAME}']),
        (SHARE, ['package.xml']),
        # What no console script is, for these would stand in every user's PATH.
        (f'lib/{NAME}', ['scripts/compile', 'scripts/record', 'scripts/status']),
        *(shared(folder) for folder in ('config', 'launch', 'scenes') if Path(folder).is_dir()),
    ],
    # The package may be installed read-only: kernels are kept elsewhere (cache_folders.py).
    zip_safe=False,
    install_requires=CORE,
    extras_require=EXTRAS,
    entry_points={
        'console_scripts': [
            'drake_geom_ros = drake_geom_ros.programs:drake_geom_ros',
            'scene_graph_node = drake_geom_ros.programs:scene_graph_node',
            'scene_viewer = drake_geom_ros.programs:scene_viewer',
            'pose_player = drake_geom_ros.programs:pose_player',
        ]
    },
)
