"""Subcommands of the command line that need no ROS: ``query``, ``check``, ``view`` and others.

Each reads arguments and files, writes text, tables or files, and returns an exit code.
"""
