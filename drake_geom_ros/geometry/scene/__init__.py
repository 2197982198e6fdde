"""``SceneGraph``: registers sources, frames and geometries, and makes contexts and query objects.

Input ports take the poses of a source; the query port gives a ``QueryObject``. Kernels may be
compiled in advance, so that no query waits for them.
"""
