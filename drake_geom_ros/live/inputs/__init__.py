"""Inputs of the live scene: poses, TF, joint states, robots, sensors, tracked bodies, objects.

Each turns the values of a message into a change of the scene, or reports what is wrong with them.
"""
