"""Motion over time without ROS: forward kinematics, joint trajectories, grasps, timed poses."""
