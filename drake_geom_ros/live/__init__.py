"""The live scene of a node and all that it does with messages, without any import of ROS.

Messages are objects with the right fields; publishers, loggers and clocks are handed in.
"""
