"""World state: poses of frames and geometries, bounds, and how far bodies moved.

The only holder of poses. From X_PF it computes X_WF and X_WG, the bounds of each body, and the
error that rounding adds to them.
"""
