"""Geometry queries over ROS 2: the scene model, the query engine and the node."""
