"""Gradients of distances by the motions of both bodies.

Computed from rows of answers and the poses that they belong to. Each gradient has a flag that
states whether it is unique, and the pair of features that touch.
"""
