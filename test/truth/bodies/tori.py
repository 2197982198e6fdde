"""Tori as solid meshes, which have a hole that their hull has not."""

import numpy as np

from drake_geom_ros.cross_check.bodies import Body


def torus(n, m, thick=0.3):
    """Return a torus of radius 1 about z, of 2 n m triangles."""
    u, v = np.meshgrid(*(2.0 * np.pi * np.arange(k) / k for k in (n, m)), indexing='ij')
    out = 1.0 + thick * np.cos(v)
    vertices = np.stack((out * np.cos(u), out * np.sin(u), thick * np.sin(v)), -1).reshape(-1, 3)
    i, j = (k.ravel() for k in np.indices((n, m)))
    a, b = i * m + j, (i + 1) % n * m + j
    c, d = (i + 1) % n * m + (j + 1) % m, i * m + (j + 1) % m
    return Body('Solid', vertices, triangles=np.vstack((np.c_[a, b, c], np.c_[a, c, d])))
