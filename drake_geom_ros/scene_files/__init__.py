"""Scene files: load scenes and models into a scene graph, and save a scene as YAML.

``load_scene`` is all that most callers need::

    scene_graph = SceneGraph()
    loaded = load_scene('scenes/two_pandas.yaml', scene_graph)
    hand = loaded.frames['left', 'panda_hand']

``read_scene`` returns the description alone (robots with their URDF and base pose, frames with
their first poses), ``register`` registers one, ``save_scene`` writes a scene graph as text. Errors
name file and line.
"""

from drake_geom_ros.scene_files.built_scenes import from_mujoco, from_pydrake
from drake_geom_ros.scene_files.cameras import add_renderers, camera_of, check_camera
from drake_geom_ros.scene_files.description import (
    FAR,
    IMAGES,
    NEAR,
    PERCEPTION,
    RATE,
    WORLD,
    AwaitedFilter,
    CameraDescription,
    CliqueDescription,
    DeactivationDescription,
    DeclarationDescription,
    FilterDescription,
    FrameDescription,
    GeometryDescription,
    GroupDescription,
    Member,
    Operation,
    RobotDescription,
    RobotOptions,
    SceneDescription,
    Statement,
    hulls_in_words,
)
from drake_geom_ros.scene_files.errors import Location, SceneFileError
from drake_geom_ros.scene_files.gates import Gate, gates_left_out, gates_of_text, shared_topic
from drake_geom_ros.scene_files.input_files import files_of
from drake_geom_ros.scene_files.leaving_out import without_source
from drake_geom_ros.scene_files.model_files import robot_name, text_format
from drake_geom_ros.scene_files.obstacle_sources import (
    DEPTH_IMAGE,
    FREE,
    LASER_SCAN,
    MAPS,
    OCCUPANCY_GRID,
    OCCUPIED,
    OCTOMAP,
    POINT_CLOUD,
    RANGE,
    ObstacleSource,
    SourceQos,
    obstacle_source_of_text,
    obstacle_sources_of_text,
    sensors_left_out,
)
from drake_geom_ros.scene_files.registration import (
    LoadedScene,
    apply_filter,
    register,
    register_rehearsed,
    warm_up,
)
from drake_geom_ros.scene_files.resources import ResourceResolver, share_folders
from drake_geom_ros.scene_files.robot_topics import (
    RobotTopics,
    placed_robot,
    robot_topics_of_text,
)
from drake_geom_ros.scene_files.saving import describe, describe_moment, poses_in_parents
from drake_geom_ros.scene_files.scene_file import load_scene, read_scene, save_scene
from drake_geom_ros.scene_files.schema import scene_schema
from drake_geom_ros.scene_files.touch_links import (
    TouchLinks,
    carried_frames,
    touch_filter,
    touched_geometries,
)
from drake_geom_ros.scene_files.yaml_writer import obstacle_source_text, to_yaml

__all__ = [
    'load_scene',
    'from_pydrake',
    'from_mujoco',
    'read_scene',
    'save_scene',
    'register',
    'register_rehearsed',
    'warm_up',
    'apply_filter',
    'AwaitedFilter',
    'describe',
    'describe_moment',
    'poses_in_parents',
    'without_source',
    'to_yaml',
    'scene_schema',
    'robot_name',
    'text_format',
    'files_of',
    'hulls_in_words',
    'TouchLinks',
    'carried_frames',
    'touch_filter',
    'touched_geometries',
    'WORLD',
    'IMAGES',
    'PERCEPTION',
    'NEAR',
    'FAR',
    'RATE',
    'add_renderers',
    'camera_of',
    'check_camera',
    'RobotOptions',
    'RobotTopics',
    'placed_robot',
    'robot_topics_of_text',
    'LoadedScene',
    'SceneDescription',
    'Gate',
    'ObstacleSource',
    'gates_left_out',
    'gates_of_text',
    'shared_topic',
    'SourceQos',
    'obstacle_source_of_text',
    'obstacle_sources_of_text',
    'obstacle_source_text',
    'sensors_left_out',
    'DEPTH_IMAGE',
    'LASER_SCAN',
    'FREE',
    'MAPS',
    'OCCUPANCY_GRID',
    'OCCUPIED',
    'OCTOMAP',
    'RANGE',
    'POINT_CLOUD',
    'RobotDescription',
    'FrameDescription',
    'GeometryDescription',
    'CameraDescription',
    'GroupDescription',
    'CliqueDescription',
    'DeclarationDescription',
    'DeactivationDescription',
    'FilterDescription',
    'Statement',
    'Operation',
    'Member',
    'ResourceResolver',
    'share_folders',
    'SceneFileError',
    'Location',
]
