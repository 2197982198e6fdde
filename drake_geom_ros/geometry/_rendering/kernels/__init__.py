"""Kernels of the renderer: scalar code for Numba, no arrays made, nothing raised.

Everything is in the sensor's frame C (z ahead, x right, y down), or in a body's frame G. A pixel's
ray is ``o + t d`` with o the camera and ``d_C = (x, y, 1)``: t is the depth. A pixel shows the
nearest surface between ``near`` and ``far``, seen from outside, or from within where the camera is
in a body or the body's front is cut away.

``view``, 10 numbers: focal_x, focal_y, center_x, center_y [pixels], near, far [m], and the world's
up in C (3), spare.

Primitives are convex: a ray enters and leaves them once, at (t_in, t_out), and t_in > t_out where
it misses. ``shape``: radius of a SPHERE; half sizes of a BOX; radius and half length of CAPSULE
and CYLINDER; semi-axes of an ELLIPSOID (as ``_proximity.kernels`` lays them out).

An image is drawn by bands of rows (``bands.Band``). Loops over the pixels of a row are written so
that LLVM vectorises them: slices known to be contiguous, of at most so many arrays as it checks
to be apart, selections and no branches, and the kind of a body known when they are compiled.
"""
