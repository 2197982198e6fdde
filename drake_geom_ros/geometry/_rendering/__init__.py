"""PRIVATE: posed shapes and a camera in, images out; arrays only. Compiled on first use.

In: packed bodies, posed in the camera's frame.
Out: images as arrays.
May import: ``math``, ``_proximity``; numpy, numba.
"""
