"""ROS 2: the node, its player, and the one place where messages are met."""
