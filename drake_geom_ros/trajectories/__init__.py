"""Motion over time without ROS: forward kinematics, joint trajectories, grasps, timed poses.

In: joint trajectories, grasps, tables of poses.
Out: poses of frames at any time.
May import: ``math``, ``autodiffutils``, ``common``, ``geometry``, ``scene_files``; numpy, yaml.

``Kinematics`` poses the links of a URDF by joint values, and gives their Jacobians::

    kinematics = Kinematics('robot.urdf')
    X_WLs = kinematics.link_transforms(q, X_WB)

``load_motion`` reads a motion file, which ``pose_player`` and the viewer play, of the frames of a
scene that ``read_scene`` has read.
"""

from drake_geom_ros.trajectories.kinematics import Kinematics
from drake_geom_ros.trajectories.motion import Grasp, Motion, RobotMotion
from drake_geom_ros.trajectories.motion_file import load_motion
from drake_geom_ros.trajectories.timed_poses import TimedPoses, read_timed_poses

__all__ = [
    'Kinematics',
    'load_motion',
    'read_timed_poses',
    'Motion',
    'RobotMotion',
    'Grasp',
    'TimedPoses',
]
