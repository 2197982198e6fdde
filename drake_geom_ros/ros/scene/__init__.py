"""The one live scene of a node, behind its lock. No ROS import.

In: poses and changes, checked by ``conversions``.
Out: views of one moment, which no later change reaches.
May import: ``math``, ``common``, ``sensors``, ``geometry``, ``proximity_rules``, ``sensed_maps``,
    ``scene_files``, ``conversions``, ``trajectories``; numpy.
"""
