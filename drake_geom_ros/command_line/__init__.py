"""The command line without ROS: ``query``, ``check`` and ``convert`` on scene and pose files."""
