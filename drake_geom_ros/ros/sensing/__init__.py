"""What sensors see, in a process of its own: clouds and depth images become cells there.

In: messages of sensors; where the sensor and the bodies were, asked of the node over a pipe.
Out: cells of a map and counts, which the node takes into its scene; refusals with their reasons.
May import: ``math``, ``common``, ``sensors``, ``geometry``, ``proximity_rules``, ``sensed_maps``,
    ``scene_files``, ``conversions``, ``scene``, ``inputs``; numpy, ROS.
"""
