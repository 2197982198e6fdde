"""Motion over time: forward kinematics, joint trajectories, grasps, timed poses.

``Kinematics`` poses the links of a URDF by joint values, and gives their Jacobians::

    kinematics = Kinematics('robot.urdf')
    X_WLs = kinematics.link_transforms(q, X_WB)

``load_motion`` reads a motion file for the frames of a scene that ``read_scene`` has read. The
program ``pose_player`` and the viewer play such files.
"""

from drake_geom_ros.trajectories.joint_spline import JointSpline, JointTrajectory
from drake_geom_ros.trajectories.kinematics import Kinematics
from drake_geom_ros.trajectories.motion import Grasp, Motion, RobotMotion
from drake_geom_ros.trajectories.motion_file import load_motion
from drake_geom_ros.trajectories.timed_poses import TimedPoses, read_timed_poses
from drake_geom_ros.trajectories.trajectory_file import NamedTrajectory, read_trajectory

__all__ = [
    'JointSpline',
    'JointTrajectory',
    'NamedTrajectory',
    'Kinematics',
    'load_motion',
    'read_timed_poses',
    'read_trajectory',
    'Motion',
    'RobotMotion',
    'Grasp',
    'TimedPoses',
]
