"""Hard cases that are no distance of a pair: who collides with whom, and what is refused.

``scenes.json`` holds them: bodies as in the catalogue, each with a name and, where it is fixed to
the world, ``anchored``; and what is ``expected``: ``collides``; ``penetrations`` (names and depth
[m]) and ``pairs`` within ``max_distance`` (names and distance [m]), complete lists; ``by_name``,
pairs that raise when they are asked for, and what the error names; ``refused``, what the error
says that keeps the bodies out.
"""

import json
import math
from pathlib import Path

import numpy as np
import pytest

from drake_geom_ros.geometry import GeometryError, MeshFileError
from truth.bodies.random_bodies import random_rotation
from truth.hard_cases.cases import body_of
from truth.judging.asking import BodyScene

SCENES = json.loads((Path(__file__).parent / 'scenes.json').read_text())
PLAIN = [scene for scene in SCENES if 'refused' not in scene['expected']]
REFUSED = [scene for scene in SCENES if 'refused' in scene['expected']]
TURNED = random_rotation(np.random.default_rng(1))


class Asked:
    """The scene of an entry, turned as a whole."""

    def __init__(self, scene, R):
        bodies = {each['name']: body_of(each).moved(R, np.zeros(3)) for each in scene['bodies']}
        still = [each['name'] for each in scene['bodies'] if each.get('anchored', False)]
        names = [name for name in bodies if name not in still] + still
        asked = BodyScene(
            [bodies[name] for name in names if name not in still], [bodies[name] for name in still]
        )
        self.ids = dict(zip(names, asked.ids, strict=True))
        self.query = asked.asked()

    def listed(self, results, lengths):
        """Return {names: length} of a result sequence."""
        names = {each.get_value(): name for name, each in self.ids.items()}
        rows = zip(results.id_A.tolist(), results.id_B.tolist(), lengths.tolist(), strict=True)
        return {frozenset((names[a], names[b])): length for a, b, length in rows}


def expected(entries):
    return {frozenset(names): pytest.approx(length, abs=1e-14) for *names, length in entries}


@pytest.mark.parametrize('R', [np.eye(3), TURNED], ids=['as it is', 'turned'])
@pytest.mark.parametrize('scene', PLAIN, ids=lambda scene: scene['id'])
def test_who_meets_whom(scene, R):
    asked, wanted = Asked(scene, R), scene['expected']
    assert asked.query.HasCollisions() == wanted['collides']
    overlaps = asked.query.ComputePointPairPenetration()
    assert asked.listed(overlaps, overlaps.depth) == expected(wanted['penetrations'])
    if 'pairs' in wanted:
        reach = scene.get('max_distance', math.inf)
        near = asked.query.ComputeSignedDistancePairwiseClosestPoints(reach)
        assert asked.listed(near, near.distance) == expected(wanted['pairs'])
    for first, second, named in wanted.get('by_name', ()):
        for a, b in ((first, second), (second, first)):
            with pytest.raises(GeometryError, match=named):
                asked.query.ComputeSignedDistancePairClosestPoints(asked.ids[a], asked.ids[b])


@pytest.mark.parametrize('scene', REFUSED, ids=lambda scene: scene['id'])
def test_what_bounds_no_solid_is_refused(scene):
    with pytest.raises(MeshFileError, match=scene['expected']['refused']):
        Asked(scene, np.eye(3))


def test_identities_are_unique_and_sources_are_named():
    assert len({scene['id'] for scene in SCENES}) == len(SCENES)
    assert all(scene['source'] and scene['about'] for scene in SCENES)
