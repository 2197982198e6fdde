"""Pair kernels called for one pair, by its numbers."""

import numpy as np

from drake_geom_ros.geometry._proximity.kernels.calling.pairs import Aim, OrientedShape


def call_for_pair(
    kernel,
    kind_A,
    shape_A,
    R_WA,
    kind_B,
    shape_B,
    R_WB,
    p_AB_W,
    tolerance,
    cutoff,
    out,
    accuracy=0.0,
):
    """Write the row ``out`` of a pair; its first columns hold a hint."""
    A = OrientedShape(int(kind_A), shape_A, np.ascontiguousarray(R_WA))
    B = OrientedShape(int(kind_B), shape_B, np.ascontiguousarray(R_WB))
    aim = Aim(1.0, float(tolerance), float(cutoff), float(accuracy))
    kernel(A, B, np.array(p_AB_W, dtype=float), aim, out)
