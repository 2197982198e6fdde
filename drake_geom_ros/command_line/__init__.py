"""The command line without ROS: ``query``, ``batch``, ``check``, ``convert``, ``view``, ..."""
