"""ROS 2 node ``scene_graph``, the pose player, and everything else that imports ROS in a node.

The node reads parameters, topics and services; it publishes results, markers and diagnostics.
"""
