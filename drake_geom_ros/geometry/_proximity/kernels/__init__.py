"""Kernels: the signed distance of one pair of shapes, written as scalar code for Numba.

Conventions, for every pair kernel (A, B)::

    kernel(A, B, p_AB_W, aim, out)

========== ========================================================================
A, B       each an ``OrientedShape``: ``kind``, the shape type number, for the kernel that serves
           many pairs; ``shape``, see *Shape parameters* (float64, 1-D); ``R_W`` (3, 3), C order
p_AB_W     position of Bo from Ao, in World axes (3,) [m]: a kernel never sees how far
           the pair is from the world's origin, so an offset costs it no digits
aim        an ``Aim``: ``tolerance``, how far [m] apart the certified bounds at which an iteration
           may stop (a closed form ignores it); ``cutoff`` [m], once the distance is certified to
           exceed it a kernel may stop and report its lower bound with BOUND_ONLY as method,
           infinity: never; the ``size`` of the pair's shapes [m]; and the ``accuracy`` [m] that
           is wanted, which kernels of solids may use up: iterations aim for ``tolerance``
out        one row of PAIR_WIDTH numbers, see ``calling.pairs``. On entry its normal is a *hint*:
           nhat_BA_W of an earlier answer of the same pair, or zeros. A row may have SLOT_WIDTH
           columns and MEMORY_WIDTH more: there, zeros at first, a kernel of hulls keeps
           a hint of its own (``cores.remembered``)
========== ========================================================================

An iterative kernel starts from the hint: a good one saves most of its time, a bad one some steps.
Whatever it is, of any length or not even finite, the certificate of the answer holds. Closed forms
ignore it.

Signs and frames. ``phi(A, B) = max over unit n of (-h_A(n) - h_B(-n))`` with n out of A
towards B: a separation where positive, minus the shortest separating translation where negative.
``nhat_BA_W`` is unit, points out of B into A (so it is minus the maximising n).
Witness points ``p_ACa_W``, ``p_ACb_W`` lie on the surfaces of A and B, are measured from Ao and
expressed in World axes, and ``p_ACa_W - p_ACb_W = distance * nhat_BA_W`` holds for either sign.
Where the answer is not unique the choice is documented in the kernel and UNIQUE is 0.

A shape grown by a ball of radius r has ``h(n) + r`` as support function, so
``phi(A + rA, B + rB) = phi(A, B) - rA - rB`` for either sign: a sphere is a point with a
radius, a capsule a segment with a radius, and one kernel of the cores serves both.

Shape parameters (half sizes, in the geometry's frame; their places have names in ``kinds``):

========== ============================= ==========================================
SPHERE     radius
BOX        hx, hy, hz                    half the width, depth and height
CAPSULE    radius, half_length           axis z; half_length of the segment
CYLINDER   radius, half_length           axis z
ELLIPSOID  a, b, c                       semi-axes
HALF_SPACE (none)                        occupies z <= 0
CONVEX     n, then n x 3 vertices, ...   in the geometry's frame, scaled; see ``hulls``
SOLID      those of CONVEX, then a tree  see ``solids.solid``
maps       those of CONVEX, then a tree  OCCUPIED_CELLS, POINT_CLOUD: see ``shapes.maps``
========== ============================= ==========================================

Words, as in the literature (C. Ericson, *Real-Time Collision Detection*, 2005; G. van den Bergh,
*Collision Detection in Interactive 3D Environments*, 2003):

support function   h(n), the largest n . x of a body's points x, for a unit n; its *support point*
                   attains it; the *width* of an overlap is the support value of its difference
witness points     Ca and Cb, the points that attain a distance or a depth
separating         a move of A after which the bodies are apart
translation
penetration depth  -phi of bodies that overlap: the length of the shortest separating translation
Minkowski          D = {a - b}, which holds the origin where A and B overlap; the ball about the
difference         origin that just fits into D has the depth as radius
separation         a lower bound of the distance of two bodies: a slab along an axis, or boxes
level gap          the largest gap between the certified bounds that an accuracy level allows
cutoff             distance beyond which nothing is reported; pydrake's *threshold* for points
skin               the margin of a body's box that keeps a neighbour list valid for a while
core               a body without the ball that it is grown by
separating axis    a direction along which a slab between the bodies is empty
certificate        two numbers that phi is between: a pair of points above, a slab below
GJK                walks with a *simplex*, up to four points of D, to the one nearest to the origin
EPA                grows a *polytope* in D at the face nearest to the origin; the new vertex sees
                   some faces, and the edges around these are its *horizon*
curvature          radii of curvature of the surface of D: they distinguish a minimum of h from a
                   saddle
kink, crease       where h has no derivative: n is normal to a segment that D is a sum of
ring               directions about an axis that are almost as good as the best
warm start         a start from the answer of an earlier pose, the *hint*
branch and bound   a descent of two trees of boxes that skips what is farther than the best so far
winding number     1 in a closed surface and 0 outside: the solid angles of its triangles over 4 pi
feature            the vertex, edge or face of a body that is extreme along n
candidate pair     two bodies whose boxes, grown by a skin or the cutoff, overlap
slack              what is left of a lower bound of a pair's distance after moves since the answer
noise              a bound of the rounding of a distance [m], proportional to the pair's size
plain overlap      an overlap by clearly more than rounding, proved without the exact depth
scratch            arrays that a walk works on, reused from one pair or point to the next

A kernel never raises, never loops without a bound, never writes NaN, and allocates nothing on
the heap that grows with its input. 3-vectors are tuples of three floats (``vectors``).
Every epsilon comes from ``tolerances``, where its reason stands.
"""
