"""Which boxes are near, by a look at each pair of them: for few bodies, or if all are asked for.

One body's box is compared with eight others' at a time, without a branch: which boxes are near is
new in each cycle, and a branch that is guessed wrong costs as much as the looks at ten.
"""

from __future__ import annotations

from drake_geom_ros.geometry._proximity.broadphase import put_code
from drake_geom_ros.geometry._proximity.compiled import compiled, inlined
from drake_geom_ros.geometry._proximity.kernels.calling.views import part, row
from drake_geom_ros.geometry._proximity.tolerances import EPS

WORD = 8  # flags, which are looked at together


@inlined
def _set_sides(lowers, uppers, distance, sides):  # type: ignore[no-untyped-def]
    """Write the sides (6, n) of boxes, of which the lower ones are out by a distance [m].

    Corners are rounded, and the sums of them and the distance: each by half a spacing at most, of
    numbers that where it matters are about as large.
    """
    for g in range(lowers.shape[0]):
        far = distance
        for c in range(3):
            far += abs(lowers[g, c]) + abs(uppers[g, c])
        for c in range(3):
            sides[c, g] = lowers[g, c] - distance - 8.0 * EPS * far
            sides[3 + c, g] = uppers[g, c]


@inlined
def _flag(near, i):  # type: ignore[no-untyped-def]
    """Flag those of the bodies after i that are near, or planes as i may be."""
    sides, first, n = near.sides, i + 1, near.is_plane.size
    x_0, y_0, z_0 = sides[0, i], sides[1, i], sides[2, i]
    x_1, y_1, z_1 = sides[3, i], sides[4, i], sides[5, i]
    x_0s, x_1s = part(row(sides, 0), first, n), part(row(sides, 3), first, n)
    y_0s, y_1s = part(row(sides, 1), first, n), part(row(sides, 4), first, n)
    z_0s, z_1s = part(row(sides, 2), first, n), part(row(sides, 5), first, n)
    flags, planes = part(near.flags, 0, n - first), part(near.is_plane, first, n)
    plane = near.is_plane[i]
    for j in range(flags.size):
        along_x = (x_0s[j] <= x_1) & (x_0 <= x_1s[j])
        along_y = (y_0s[j] <= y_1) & (y_0 <= y_1s[j])
        along_z = (z_0s[j] <= z_1) & (z_0 <= z_1s[j])
        flags[j] = plane | planes[j] | (along_x & along_y & along_z)


@compiled
def look_at_all(near, world, distance):  # type: ignore[no-untyped-def]
    """Fill in the codes of near pairs, in order; return how many there are, beyond the room too.

    ``near`` is a ``ListArrays``. Those of two anchored bodies, or of two planes, are left out;
    every body is paired with every plane, so that these may move freely.
    """
    n, count, frames = near.is_plane.size, 0, world.frames
    _set_sides(near.lowers, near.uppers, distance, near.sides)
    for i in range(n):
        _flag(near, i)
        others = n - (i + 1)
        for word in range((others + WORD - 1) // WORD):
            if near.words[word] != 0:
                for j in range(WORD * word, min(WORD * word + WORD, others)):
                    k = i + 1 + j
                    fixed = (frames[i] == 0) & (frames[k] == 0)
                    both = near.is_plane[i] & near.is_plane[k]
                    kept = near.flags[j] & (not (fixed | both))
                    count = put_code(near.found, count, i, k, kept)
    return count
