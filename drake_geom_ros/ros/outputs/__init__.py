"""What goes out by itself: results of cycles, markers, diagnostics, replay files.

In: the live scene, when something is due.
Out: messages, published or written.
May import: ``math``, ``common``, ``sensors``, ``geometry``, ``proximity_rules``, ``sensed_maps``,
    ``scene_files``, ``conversions``, ``scene``, ``replay``, ``cross_check``, ``viewing``; numpy,
    ROS.
"""
