"""The command line without ROS: ``query``, ``batch``, ``check``, ``convert``, ``view``, ...

In: arguments of the shell and files.
Out: text, tables and files, and exit codes.
May import: ``math``, ``common``, ``sensors``, ``geometry``, ``scene_files``, ``trajectories``,
    ``replay``, ``batch``, ``cross_check``, ``viewing``, ``recordings``, ``sensed_maps``; numpy,
    PIL, matplotlib.
"""
