"""One shape alone: its bounds, support points, features and packed numbers.

Enters: a kind and the packed numbers of a shape. Leaves: radii, support points in a direction,
inner balls, the feature at a point. Nothing here knows a second body.
"""
