"""How to ask other libraries the question that this one answers: two shapes, two poses.

None of them is needed by anything else here, and each is imported only when it is loaded::

    from drake_geom_ros.geometry import Box, Sphere
    from drake_geom_ros.math import RigidTransform
    from truth.peers import installed, load

    for name in installed():
        ask = load(name).pair('penetration', Sphere(1), Box(1, 1, 1))
        print(name, ask(RigidTransform(), RigidTransform([0.9, 0, 0])))
"""

from drake_geom_ros.cross_check.answers import (
    PENETRATION,
    QUERIES,
    SIGNED_DISTANCE,
    Ask,
    PairAnswer,
    Peer,
    SolidMesh,
    Unsupported,
)
from truth.peers.registry import installed, load, names, version

__all__ = [
    'names',
    'installed',
    'version',
    'load',
    'Peer',
    'PairAnswer',
    'Ask',
    'Unsupported',
    'SolidMesh',
    'QUERIES',
    'SIGNED_DISTANCE',
    'PENETRATION',
]
