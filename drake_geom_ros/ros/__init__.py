"""ROS 2: the node, its player, and the one place where messages are met.

In: parameters, topics and services.
Out: results, markers and diagnostics.
May import: ``math``, ``common``, ``sensors``, ``geometry``, ``proximity_rules``, ``sensed_maps``,
    ``scene_files``, ``conversions``, ``scene``, ``trajectories``, ``cross_check``, ``inputs``,
    ``outputs``, ``services``, ``sensing``; numpy, ROS.
"""
