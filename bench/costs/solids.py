"""Time of two solids that are linked, flush or fit each other, over that of the same two apart.

    ./run exec python -m bench.costs.solids

Processor time of one thread, the least of some rounds; microseconds, and how many times those
apart take. Turned: both by one rotation, whose rounding parts what fits or lets it interlock.
Whether: how long it takes to tell no more than whether they overlap. Beside it Coal's ``distance``
of the surfaces apart and together, and its ``collide``; it has no depth of solids. At last tori
that are linked at random.
"""

import time
from collections.abc import Callable

import numpy as np
from scipy.spatial.transform import Rotation

from drake_geom_ros.cross_check.bodies import Body
from drake_geom_ros.geometry import MeshData
from drake_geom_ros.geometry._proximity.kernels.calling import pairs as calling
from drake_geom_ros.geometry._proximity.kernels.solids.pairs import signed_distance_to_solid
from drake_geom_ros.geometry._proximity.kernels.solids.plain_overlap import plain_overlap
from drake_geom_ros.geometry._proximity.kinds import Method
from drake_geom_ros.geometry.meshes._solids import solid_of
from truth.bodies.grids import L, flat, surface
from truth.bodies.random_bodies import random_rotation
from truth.bodies.tori import torus
from truth.peers.coal_peer import coal_shape

ROUNDS, LEAST = 5, 0.02  # [s] a round
LINES = [np.arange(9.0)] * 3
SLOT, CAP = flat('###', '#.#'), [(0, 1, 0), (1, 1, 0), (2, 1, 0), (1, 0, 0)]


def grid(cells, cuts):
    """Return a union of cells, its faces cut, as a solid."""
    vertices, triangles = surface(cells, LINES, cuts)
    return Body('Solid', vertices, triangles=triangles)


def placed():
    """Yield (name, A, B, offset of A where they are together, and where apart)."""
    upright = np.array([[1.0, 0, 0], [0, 0, -1.0], [0, 1.0, 0]])
    for n, m in ((12, 10), (32, 23)):
        ring = torus(n, m)
        other = ring.placed(upright, np.zeros(3))
        yield f'linked tori of {2 * n * m}', other, ring, (1.0, 0.0, 0.0), (3.0, 0.0, 0.0)
        near = 1.0 + 0.4 - 1e-3
        yield f'linked and nearly touching, {2 * n * m}', other, ring, (near, 0, 0), (3.0, 0, 0)
        yield f'tori that cross, {2 * n * m}', other, ring, (1.5, 0.2, 0.1), (3.0, 0, 0)
    for cuts in (1, 3, 6):
        block, wall = grid(CAP, cuts), grid(SLOT, cuts)
        count = len(block.triangles)
        yield f'a T in its slot, {count}', block, wall, (0.0, 1.0, 0.0), (0.0, 3.0, 0.0)
        one = grid(L, cuts)
        count = len(one.triangles)
        yield f'an L on an L, {count}', one, one, (0.0, 0.0, 1.0), (0.0, 0.0, 2.0)
        yield f'an L in line with an L, {count}', one, one, (2.0 - 1e-9, 0, 0), (3.0, 0, 0)
        yield f'an L 1 mm in an L, {count}', one, one, (0, 0, 0.999), (0, 0, 2.0)


def packed(body, R):
    """Return a body's shape and place as kernels take them, turned by R."""
    kind, shape = solid_of(MeshData(body.size, body.triangles), (1.0, 1.0, 1.0))
    return calling.OrientedShape(kind, shape, np.ascontiguousarray(R @ body.R)), R @ body.p


def time_of(ask: Callable[[], object]) -> float:
    """Return the processor time [s] of a call, the least of some rounds."""
    best, count = np.inf, 1
    for _ in range(ROUNDS):
        while True:
            start = time.thread_time()
            for _ in range(count):
                ask()
            taken = time.thread_time() - start
            if taken > LEAST or taken > 0.5:
                break
            count = max(count + 1, int(1.5 * count * LEAST / max(taken, 1e-6)))
        best = min(best, taken / count)
    return best


def asked(A, B, at, out):
    """Return the processor time [s] of one answer, which is in ``out``."""
    (shaped_A, p_A), (shaped_B, p_B) = A, B
    p, aim = p_B - (p_A + at), calling.Aim(size=0.0, tolerance=1e-9, cutoff=np.inf, accuracy=0.0)

    def ask():
        out[calling.NORMAL : calling.NORMAL + 3] = 0.0
        signed_distance_to_solid(shaped_A, shaped_B, p, aim, out)

    return time_of(ask)


def whether(A, B, at):
    """Return the processor time [s] of telling whether they overlap, as HasCollisions does."""
    (shaped_A, p_A), (shaped_B, p_B) = A, B
    p, aim = p_B - (p_A + at), calling.Aim(size=0.0, tolerance=1e-9, cutoff=1e-14, accuracy=0.0)
    out = np.empty(calling.PAIR_WIDTH)

    def ask():
        out[calling.NORMAL : calling.NORMAL + 3] = 0.0
        plain_overlap(shaped_A, shaped_B, p, aim, out)
        if out[calling.DISTANCE] == 0.0:
            signed_distance_to_solid(shaped_A, shaped_B, p, aim, out)

    return time_of(ask)


def of_coal(A, B, near, far):
    """Return the processor times [s] of Coal's distance, apart and together, and of collide."""
    import coal

    a, b = coal_shape(A.shape), coal_shape(B.shape)
    X_WB, request, contact = (
        coal.Transform3s(B.R, B.p),
        coal.DistanceRequest(),
        coal.CollisionRequest(),
    )
    found, hit = coal.DistanceResult(), coal.CollisionResult()
    times = []
    for at in (far, near):
        X_WA = coal.Transform3s(A.R, A.p + at)

        def ask(X_WA=X_WA):
            found.clear()
            coal.distance(a, X_WA, b, X_WB, request, found)

        times.append(time_of(ask))

    def collide():
        hit.clear()
        coal.collide(a, X_WA, b, X_WB, contact, hit)

    return (*times, time_of(collide))


def linked_at_random(n, m, count=40):
    """Return how many times as long as tori apart such take that are linked at random."""
    ring, rng = torus(n, m), np.random.default_rng(1)
    upright = np.array([[1.0, 0, 0], [0, 0, -1.0], [0, 1.0, 0]])
    row, times = np.empty(calling.PAIR_WIDTH), []
    while len(times) < count:
        R = upright @ Rotation.from_rotvec(rng.uniform(-0.6, 0.6, 3)).as_matrix()
        a, b = packed(ring.placed(R, np.zeros(3)), np.eye(3)), packed(ring, np.eye(3))
        at = np.array([1.0, 0.0, 0.0]) + rng.uniform(-0.35, 0.35, 3)
        together = asked(a, b, at, row)
        if row[calling.DISTANCE] > 0.0:
            times.append(together / asked(a, b, np.array([3.0, 0.0, 0.0]), row))
    return times


def main():
    rng = np.random.default_rng(3)
    R = random_rotation(rng)
    print(
        f'{"":34}{"apart":>8}{"together":>10}{"times":>7}   turned{"times":>7}'
        f'{"whether":>9}   {"Coal":>8}{"together":>10}{"collide":>9}   answers'
    )
    for name, A, B, near, far in placed():
        text, answers, near, far = f'{name:34}', [], np.array(near), np.array(far)
        for rotation in (np.eye(3), R):
            a, b = packed(A, rotation), packed(B, rotation)
            rows = np.empty((2, calling.PAIR_WIDTH))
            apart = asked(a, b, rotation @ far, rows[0])
            together = asked(a, b, rotation @ near, rows[1])
            if rotation is not R:
                text += f'{1e6 * apart:8.1f}'
            text += f'{1e6 * together:10.1f}{together / apart:7.1f}'
            row = rows[1]
            method = Method(int(row[calling.METHOD])).words
            answers.append(f'{row[0]:.3g}+-{row[calling.ERROR_BOUND]:.1g} {method}')
        a, b = packed(A, np.eye(3)), packed(B, np.eye(3))
        apart, together, collide = of_coal(A, B, near, far)
        text += f'{1e6 * whether(a, b, near):9.1f}'
        text += f'   {1e6 * apart:8.1f}{1e6 * together:10.1f}{1e6 * collide:9.1f}'
        print(text, '  ' + ', '.join(answers), flush=True)
    for n, m in ((12, 10), (32, 23)):
        shares = np.quantile(linked_at_random(n, m), (0.0, 0.5, 0.9, 1.0))
        told = ', '.join(f'{x:.1f}' for x in shares)
        print(
            f'tori of {2 * n * m} linked at random: least, median, 90 of 100, most: {told} times'
        )


if __name__ == '__main__':
    main()
