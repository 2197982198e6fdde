"""Bodies that a mesh bounds, dents, holes and all: trees of boxes over their triangles.

In: packed surfaces and the pose of another body.
Out: distance or bounds of the depth, by walks over triangles.
May import: ``math``, ``_proximity``, ``runtime``, ``kernels``, ``shapes``, ``calling``,
    ``closed_forms``, ``cores``, ``trees``; numpy, numba, llvmlite.
"""
