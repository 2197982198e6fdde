"""What there is: sources, frames, geometries, properties, sets and filter declarations.

Enters: what is registered. Leaves: records by id, and versions that tell what has changed. No
poses of now, no queries: those stand in ``queries``. Imports ``shapes`` and ``meshes``.
"""
