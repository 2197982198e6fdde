"""Records for the tests of what is made of them."""

import numpy as np

from drake_geom_ros.evidence.accuracy.results import OURS, Measured, Setting
from drake_geom_ros.evidence.accuracy.samples import known
from drake_geom_ros.evidence.bodies import Body

BALL = Body('Sphere', (0.1,))
PAIR = known(BALL, BALL.at(np.array([0.3, 0.0, 0.0])), 0.1, 'apart')


def ours(level, *answers, case='Sphere-Sphere', family='spheres'):
    """Return a record of our answers, pairs of distance and bound [m], to PAIR."""
    made = Measured(case, family, 'signed_distance', Setting(OURS, level), whole=1e-5, inside=1e-6)
    for distance, bound in answers:
        made.add(PAIR, distance, bound)
    return made


def peer(name, *distances):
    """Return a record of a peer's distances [m] to PAIR, and one more that it missed."""
    setting = Setting(name, 'own settings')
    names = 'Sphere-Sphere', 'spheres', 'signed_distance'
    made = Measured(*names, setting, whole=1e-4, inside=0.0)
    for distance in distances:
        made.add(PAIR, distance)
    made.verdicts['missed'] += 1
    return made


def some():
    """Return records of four levels and two peers."""
    return [
        ours('bound', (0.15, 0.1)),
        ours('fast', (0.1 + 1e-4, 2e-4)),
        ours('balanced', (0.1 + 1e-7, 2e-7)),
        ours('exact', (0.1, 1e-15), (0.1 + 1e-11, 3e-11)),
        peer('Coal', 0.1 + 1e-6),
        peer('MuJoCo'),
    ]
