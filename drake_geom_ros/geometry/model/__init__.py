"""What there is: sources, frames, geometries, properties, sets and filter declarations.

In: what is registered.
Out: records by id, and versions that tell what has changed; no poses of now, no queries.
May import: ``math``, ``common``, ``geometry``, ``meshes``, ``shapes``, ``hydroelastic``,
    ``_proximity``; numpy.
"""
