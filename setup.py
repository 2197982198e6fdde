from pathlib import Path

from setuptools import find_packages, setup

NAME = 'drake_geom_ros'
SHARE = f'share/{NAME}'


def shared(folder):
    """List the files of a folder for the share of the package, where launch looks for them."""
    return (f'{SHARE}/{folder}', sorted(str(path) for path in Path(folder).glob('*.*')))


setup(
    name=NAME,
    version='0.1.0',
    description='Geometry service for ROS 2: signed distances, penetrations, collision filters.',
    license='Apache-2.0',
    maintainer='drake_geom_ros maintainers',
    maintainer_email='maintainers@drake-geom-ros.invalid',
    python_requires='>=3.10,<3.14',
    packages=find_packages(include=[NAME, f'{NAME}.*']),
    package_data={NAME: ['*/*.schema.json', 'evidence/hard_cases/catalogue/*.json']},
    data_files=[
        ('share/ament_index/resource_index/packages', [f'resource/{NAME}']),
        (SHARE, ['package.xml']),
        *(shared(folder) for folder in ('config', 'launch', 'scenes') if Path(folder).is_dir()),
    ],
    # The package may be installed read-only: compiled kernels are kept elsewhere (compiled.py).
    zip_safe=False,
    install_requires=['setuptools'],
    entry_points={
        'console_scripts': [
            'scene_graph_node = drake_geom_ros.ros.scene_graph_node:main',
            'pose_player = drake_geom_ros.ros.pose_player:main',
        ]
    },
)
