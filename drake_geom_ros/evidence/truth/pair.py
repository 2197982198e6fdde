"""Two bounded bodies and f(n) = -h_A(n) - h_B(-n), whose maximum is their signed distance."""

from __future__ import annotations

from typing import Any

import numpy as np
from mpmath import mp, mpf

from drake_geom_ros.evidence.truth.supports import Body, Floats


def offset_between(p_WA: Any, p_WB: Any) -> list[Any]:
    """Return p_AB in full digits."""
    return [mpf(float(b)) - mpf(float(a)) for a, b in zip(p_WA, p_WB, strict=True)]


class Pair:
    """Two bounded bodies, and f."""

    def __init__(self, a: Body, b: Body) -> None:
        self.offset = offset_between(a.p, b.p)
        zero = np.zeros(3)
        p_AB = np.array([float(x) for x in self.offset])
        self.a = Body(a.vertices, a.edges, a.radius, a.flat, a.R, zero, a.poles)
        self.b = Body(b.vertices, b.edges, b.radius, b.flat, b.R, p_AB, b.poles)
        self.size = a.size + b.size + float(np.linalg.norm(p_AB))

    def gaps(self, n: Floats) -> Floats:
        """Return the points (m, 3) of B - A that are lowest along the unit directions n (m, 3)."""
        return self.b.points(-n) - self.a.points(n)

    def values(self, n: Floats) -> Floats:
        """Return f of unit directions (m, 3)."""
        return np.einsum('ij,ij->i', self.gaps(n), n)

    def exact(self, n: list[Any]) -> Any:
        """Return f of a direction of any length, in full digits."""
        ahead = sum((x * y for x, y in zip(self.offset, n, strict=True)), mpf(0))
        value = ahead - self.a.exact_height(n) - self.b.exact_height([-x for x in n])
        return value / mp.sqrt(sum((x * x for x in n), mpf(0)))
