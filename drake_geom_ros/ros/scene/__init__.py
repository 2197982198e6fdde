"""The one live scene of a node, behind its lock. No ROS import."""
