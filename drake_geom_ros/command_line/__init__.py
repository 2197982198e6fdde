"""The command line without ROS: ``query``, ``check``, ``convert`` and ``replay`` on files."""
