"""Motion over time without ROS: forward kinematics, joint trajectories, grasps, timed poses.

In: joint trajectories, grasps, tables of poses.
Out: poses of frames at any time.
May import: ``math``, ``common``, ``geometry``, ``scene_files``; numpy, yaml.
"""
