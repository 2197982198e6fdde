"""Time of two solids that are linked, flush or fit each other, over that of the same two apart.

    ./run exec python bench/costs/solids.py

Processor time of one thread, the least of some rounds; microseconds, and how many times those
apart take. Turned: both by one rotation, whose rounding parts what fits or lets it interlock.
"""

import time

import numpy as np

from bench.evidence.bodies.grids import L, flat, surface
from bench.evidence.bodies.random_bodies import random_rotation
from drake_geom_ros.cross_check.bodies import Body
from drake_geom_ros.geometry import MeshData
from drake_geom_ros.geometry._proximity.kernels.calling import pairs as calling
from drake_geom_ros.geometry._proximity.kernels.solids.pairs import signed_distance_to_solid
from drake_geom_ros.geometry._proximity.kinds import Method
from drake_geom_ros.geometry.meshes._solids import solid_of

ROUNDS, LEAST = 5, 0.02  # [s] a round
LINES = [np.arange(9.0)] * 3
SLOT, CAP = flat('###', '#.#'), [(0, 1, 0), (1, 1, 0), (2, 1, 0), (1, 0, 0)]


def grid(cells, cuts):
    """Return a union of cells, its faces cut, as a solid."""
    vertices, triangles = surface(cells, LINES, cuts)
    return Body('Solid', vertices, triangles=triangles)


def torus(n, m, thick=0.3):
    """Return a torus of radius 1 about z, of 2 n m triangles."""
    u, v = np.meshgrid(*(2.0 * np.pi * np.arange(k) / k for k in (n, m)), indexing='ij')
    out = 1.0 + thick * np.cos(v)
    vertices = np.stack((out * np.cos(u), out * np.sin(u), thick * np.sin(v)), -1).reshape(-1, 3)
    i, j = (k.ravel() for k in np.indices((n, m)))
    a, b = i * m + j, (i + 1) % n * m + j
    c, d = (i + 1) % n * m + (j + 1) % m, i * m + (j + 1) % m
    return Body('Solid', vertices, triangles=np.vstack((np.c_[a, b, c], np.c_[a, c, d])))


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


def asked(A, B, at, out):
    """Return the processor time [s] of one answer, which is in ``out``."""
    (shaped_A, p_A), (shaped_B, p_B) = A, B
    p, aim = p_B - (p_A + at), calling.Aim(size=0.0, tolerance=1e-9, cutoff=np.inf)
    best, count = np.inf, 1
    for _ in range(ROUNDS):
        while True:
            start = time.thread_time()
            for _ in range(count):
                out[calling.NORMAL : calling.NORMAL + 3] = 0.0
                signed_distance_to_solid(shaped_A, shaped_B, p, aim, out)
            taken = time.thread_time() - start
            if taken > LEAST or taken > 0.5:
                break
            count = max(count + 1, int(1.5 * count * LEAST / max(taken, 1e-6)))
        best = min(best, taken / count)
    return best


def main():
    rng = np.random.default_rng(3)
    R = random_rotation(rng)
    print(f'{"":40}{"apart":>8}{"together":>10}{"times":>7}   turned{"times":>7}   answers')
    for name, A, B, near, far in placed():
        text, answers = f'{name:40}', []
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
        print(text, '  ' + ', '.join(answers), flush=True)


if __name__ == '__main__':
    main()
