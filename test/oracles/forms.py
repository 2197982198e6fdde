"""The true distance of two shapes as kernels have them: a type number, sizes and a pose."""

from types import SimpleNamespace

import numpy as np

from drake_geom_ros.evidence.truth import convex


def body(form, R, p=(0.0, 0.0, 0.0)):
    """Return what the truth takes of a body; ``form`` is (type number, sizes)."""
    p = np.array(p, dtype=float)
    return SimpleNamespace(form=form, R=R, p=p, X_WG=(R, p))


def signed_distance(form_A, X_WA, form_B, X_WB):
    """Return phi [m] and a unit direction (3,) out of A that attains it; a pose is (R, p)."""
    return convex.signed_distance(body(form_A, *X_WA), body(form_B, *X_WB))
