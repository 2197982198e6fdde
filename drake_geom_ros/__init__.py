"""Geometry queries over ROS 2: the scene model, the query engine and the node.

In: arguments of the shell, through ``__main__``.
Out: the exit code of a program.
May import: ``programs``.
"""
