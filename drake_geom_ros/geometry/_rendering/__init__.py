"""Ray casting renderer (private): compiled loops over arrays.

Takes packed bodies, posed in the camera's frame, and returns images as arrays. The kernels are
compiled on first use.
"""
