"""What comes in by itself: transforms, robot descriptions, points. No ROS import.

In: values of messages, when they come.
Out: changes of the live scene, and what is wrong with them.
May import: ``math``, ``common``, ``sensors``, ``geometry``, ``proximity_rules``, ``sensed_maps``,
    ``scene_files``, ``conversions``, ``scene``; numpy.
"""
