"""The scenes: what every library is given, and nothing that one of them would call its own."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from bench.peers.motion import Motion, Walk, swinging
from drake_geom_ros.cross_check.bodies import BOUNDED, Body
from drake_geom_ros.math.array_types import Floats
from truth.bodies import arms
from truth.bodies.random_bodies import random_directions, random_rotations

# Space for each body [m^3] at which bodies of these sizes have about one contact each.
ROOM = {'spheres': 0.032, 'mixed': 0.030, 'hulls': 0.020, 'anchored': 0.02}
NEAR = 0.1  # [m] max_distance of the query of that name
# Half sizes of what is not round all over, in parts of those of a ball: all are about as large.
SLIMMER = {'Box': (0.8, 0.8, 0.8), 'Capsule': (0.7, 1.0, 1.0), 'Cylinder': (0.8, 1.0, 1.0)}
QUERIES = ('penetration', 'candidates', 'near', 'all', 'points', 'has_collisions')
TENTH, SPREAD = '/tenth', '/apart'


@dataclass(frozen=True)
class Scene:
    """Bodies that are posed every cycle, one frame each, among anchored ones.

    ``anchored`` are at their poses, ``filtered`` are pairs of bodies by number, ``points`` (m, 3)
    [m] the query points, ``queries`` what is asked of the scene.
    """

    name: str
    bodies: list[Body]
    motion: Motion
    points: Floats
    anchored: list[Body]
    filtered: list[tuple[int, int]]
    queries: tuple[str, ...] = QUERIES


def shape(kind: str, rng: np.random.Generator) -> Body:
    """Return a shape of a kind, about 0.2 m wide."""
    return Body.of_halves(kind, rng.uniform(0.07, 0.13, 3) * SLIMMER.get(kind, 1.0))


def hull(rng: np.random.Generator) -> Body:
    """Return the hull of 64 points on an ellipsoid: each of them is a vertex of it."""
    return Body('Convex', random_directions(rng, 64) * rng.uniform(0.08, 0.15, 3))


def free(name: str, bodies: list[Body], half: float, rng: np.random.Generator) -> Scene:
    """Return a cube of side 2 ``half`` [m] in which bodies walk at random."""
    corners = np.full((len(bodies), 3), half)
    walk = Walk(-corners, corners, step=0.01 * np.array([body.radius for body in bodies]))
    return Scene(name, bodies, walk, rng.uniform(-half, half, (100, 3)), [], [])


def half_side(room: str, count: int) -> float:
    """Return half the side [m] of a cube with the room that many bodies want."""
    return 0.5 * (ROOM[room] * count) ** (1 / 3)


def spread(scene: Scene) -> Scene:
    """Return a scene of free bodies with a cell for each, so that nothing touches."""
    radii = np.array([b.radius for b in scene.bodies])
    cell = 2.1 * max(radii.max(), *(s.radius for s in scene.anchored), 0.0)
    count = len(radii) + len(scene.anchored)
    side = int(np.ceil(count ** (1 / 3)))
    centres = cell * np.indices((side, side, side)).reshape(3, -1).T[:count]
    # Moving and anchored bodies are neighbours all over, not two heaps.
    centres = np.random.default_rng(1).permutation(centres)
    moving, standing = centres[: len(radii)], centres[len(radii) :]
    slack = 0.5 * cell - radii[:, None]
    walk = Walk(moving - slack, moving + slack, step=0.01 * radii)
    anchored = [body.at(p) for body, p in zip(scene.anchored, standing, strict=True)]
    return replace(scene, motion=walk, anchored=anchored)


def spheres(count: int) -> Scene:
    """Return moving spheres."""
    rng = np.random.default_rng(count)
    bodies = [shape('Sphere', rng) for _ in range(count)]
    return free(f'spheres-{count}', bodies, half_side('spheres', count), rng)


def mixed(count: int) -> Scene:
    """Return moving bodies of all kinds in turn."""
    rng = np.random.default_rng(count + 1)
    return free(f'mixed-{count}', all_kinds(count, rng), half_side('mixed', count), rng)


def all_kinds(count: int, rng: np.random.Generator) -> list[Body]:
    """Return shapes of all kinds in turn."""
    return [shape(BOUNDED[k % len(BOUNDED)], rng) for k in range(count)]


def hulls(count: int) -> Scene:
    """Return moving hulls of 64 vertices."""
    rng = np.random.default_rng(count + 2)
    bodies = [hull(rng) for _ in range(count)]
    return free(f'hulls-{count}', bodies, half_side('hulls', count), rng)


def anchored(thousands: int) -> Scene:
    """Return 30 bodies that move in a cube with 1000 anchored boxes.

    More thousands fill cubes beside it: what moves has the same neighbours with any number.
    """
    rng = np.random.default_rng(3)
    half = half_side('anchored', 1000)
    scene = free(f'anchored-{1000 * thousands}', all_kinds(30, rng), half, rng)
    for block in range(thousands):
        centre = np.array([2 * half * block, 0.0, 0.0])
        for R in random_rotations(rng, 1000):
            p = centre + rng.uniform(-half, half, 3)
            scene.anchored.append(shape('Box', rng).placed(R, p))
    return scene


def two_arms(posture: Floats) -> Scene:
    """Two arms over a table with 20 boxes, adjacent links filtered."""
    rng = np.random.default_rng(7)
    table = arms.table(rng)
    points = rng.uniform((-1, -0.7, 0), (1, 0.7, 1.2), (100, 3))
    adjacent = [(7 * arm + k, 7 * arm + k + 1) for arm in range(2) for k in range(6)]
    return Scene('arms', arms.links(), swinging(posture), points, table, adjacent)


def tenth(scene: Scene) -> Scene:
    """Return the scene with a tenth of its bodies moving, the others at rest where they are."""
    return replace(scene, name=scene.name + TENTH, motion=scene.motion.tenth())


def apart(scene: Scene) -> Scene:
    """Return the scene as one without collisions, which only has_collisions is asked of."""
    scene = two_arms(arms.APART) if scene.name == 'arms' else spread(scene)
    return replace(scene, name=scene.name + SPREAD, queries=('has_collisions',))


FULL: dict[str, Callable[[], Scene]] = {
    **{f'spheres-{n}': partial(spheres, n) for n in (50, 200, 1000)},
    **{f'mixed-{n}': partial(mixed, n) for n in (50, 200, 1000)},
    'arms': partial(two_arms, arms.BENT),
    'hulls-20': partial(hulls, 20),
    **{f'anchored-{n}000': partial(anchored, n) for n in (1, 2)},
}


def build(name: str) -> Scene:
    """Return a scene by its name in ``names()``."""
    base, slash, variant = name.partition('/')
    scene = FULL[base]()
    return {'': lambda s: s, TENTH: tenth, SPREAD: apart}[slash + variant](scene)


def names() -> list[str]:
    """Return the names of all scenes: each as it is, with a tenth moving, and spread out."""
    return [base + variant for variant in ('', TENTH, SPREAD) for base in FULL]
