"""Properties of one shape: bounds, radii, support points, inner balls, and features at points.

A shape is its kind and its packed numbers. Nothing here involves a second body.
"""
