"""Model files of one robot, in any format that describes links and joints."""

from pathlib import Path

from drake_geom_ros.scene_files.description import RobotOptions
from drake_geom_ros.scene_files.resources import ResourceResolver
from drake_geom_ros.scene_files.robot_files import read_robot_file
from drake_geom_ros.scene_files.robot_parts import RobotParts
from drake_geom_ros.scene_files.urdf import read_urdf


def read_model(
    path: Path, source: str, resolver: ResourceResolver, options: RobotOptions
) -> RobotParts:
    """Return the parts of the robot in a file, owned by ``source``.

    Raises SceneFileError for a file that cannot be read, or is no model.
    """
    data, file = read_robot_file(path, resolver.is_free)
    return read_urdf(data, file, source, path.parent, resolver, options)
