"""The page in the browser for a running node: learns all from topics, asks by services.

In: topics and services of a node in another process.
Out: a scene as ``viewing`` shows it.
May import: ``math``, ``common``, ``sensors``, ``geometry``, ``proximity_rules``, ``sensed_maps``,
    ``scene_files``, ``client``, ``viewing``, ``conversions``, ``ros``; numpy, ROS.
"""
