"""Sensor process: turns clouds and depth images into cells of a map, outside the node's process.

The node sends it the poses of sensors and bodies over a pipe. It returns cells and counts, and the
reasons for messages that it rejected.
"""
