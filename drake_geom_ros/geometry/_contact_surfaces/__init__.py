"""Contact surfaces of hydroelastic bodies (private): compiled loops over arrays.

The input is packed meshes with pressures, poses and pairs of bodies. The output is the polygons of
equal pressure and their integrals by pair, and the pairs that overlap without such a polygon
because one body is deep inside the other. The kernels are compiled on first use.
"""
