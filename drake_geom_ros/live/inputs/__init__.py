"""Inputs of the live scene: transforms, robot descriptions, obstacles, points.

Each turns the values of a message into a change of the scene, or reports what is wrong with them.
"""
