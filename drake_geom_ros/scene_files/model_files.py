"""Model files of one robot, in any format that describes links and joints."""

from pathlib import Path

from drake_geom_ros.scene_files.description import RobotOptions
from drake_geom_ros.scene_files.errors import SceneFileError
from drake_geom_ros.scene_files.link_tree import LinkTree
from drake_geom_ros.scene_files.mujoco_models import read_mjcf
from drake_geom_ros.scene_files.resources import ResourceResolver
from drake_geom_ros.scene_files.robot_files import read_robot_file
from drake_geom_ros.scene_files.robot_parts import RobotParts
from drake_geom_ros.scene_files.sdf import read_sdf
from drake_geom_ros.scene_files.urdf import read_urdf
from drake_geom_ros.scene_files.urdf_tree import read_link_tree
from drake_geom_ros.scene_files.xml_tree import (
    attribute,
    place_of,
    read_xml,
    robot_xml,
    root_tag,
)


def text_format(data: bytes) -> str:
    """Return the format of a model that comes as text, ``sdf`` or ``urdf``."""
    return 'sdf' if root_tag(data) == 'sdf' else 'urdf'


def robot_name(data: bytes, file: str) -> str:
    """Return the name that a URDF, an SRDF or a model of SDFormat gives its robot.

    Raises SceneFileError for others, and for SDFormat with no model or several.
    """
    if text_format(data) == 'urdf':
        with robot_xml(data, file) as robot:
            return attribute(robot, 'name', file)
    root = read_xml(data, file, 'sdf')
    models = [*root.iterfind('model'), *root.iterfind('world/model')]
    if len(models) != 1:
        raise place_of(root, file).error(f'{len(models)} models; a robot is one')
    return attribute(models[0], 'name', file)


def read_model(
    path: Path, source: str, resolver: ResourceResolver, options: RobotOptions, model: str = ''
) -> RobotParts:
    """Return the parts of the robot in a file, owned by ``source``.

    ``model`` names one of several in a file. Raises SceneFileError for a file that cannot be read,
    or is no model.
    """
    data, file = read_robot_file(path, resolver.is_free)
    if root_tag(data) == 'mujoco':
        return read_mjcf(path, data, file, resolver, options, source)
    if root_tag(data) == 'sdf':
        return read_sdf(data, file, path.parent, resolver, options, source, model)[0][source]
    if model:
        raise SceneFileError(f'model {model!r} is asked for, and a URDF has no models', file)
    return read_urdf(data, file, source, path.parent, resolver, options)


def read_model_tree(path: Path, resolver: ResourceResolver, model: str = '') -> LinkTree:
    """Return the links and joints of a model file; errors are those of ``read_model``."""
    data, _ = read_robot_file(path, resolver.is_free)
    if root_tag(data) in ('sdf', 'mujoco'):
        return read_model(path, model or 'robot', resolver, RobotOptions(), model).tree
    return read_link_tree(path, resolver.is_free)
