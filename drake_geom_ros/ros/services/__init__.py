"""What answers calls: a handler each, and the table of all.

In: requests.
Out: responses; a refusal says what was asked, and what is allowed.
May import: ``math``, ``common``, ``sensors``, ``geometry``, ``proximity_rules``, ``sensed_maps``,
    ``scene_files``, ``conversions``, ``scene``, ``batch``, ``inputs``; numpy, ROS.
"""
