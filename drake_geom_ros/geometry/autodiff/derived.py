"""Derivatives of points and normals of results, computed when a record needs them.

They exist where the motion rotates the normal only by known curvature, see ``witnesses``.
"""

from __future__ import annotations

from functools import cached_property
from typing import Any

import numpy as np

from drake_geom_ros.autodiffutils.arrays import autodiff_array
from drake_geom_ros.geometry._proximity.derivatives.gradients import (
    Features,
    features_of_pairs,
    places_of,
)
from drake_geom_ros.geometry._proximity.kernels.calling.pairs import (
    DISTANCE,
    NORMAL,
    UNIQUE,
    WITNESS_A,
    WITNESS_B,
)
from drake_geom_ros.geometry._proximity.kinds import BOUND_ONLY, HALF_SPACE, SOLID
from drake_geom_ros.geometry._proximity.pairs.answer_rows import (
    BATCH_WIDTH,
    P_ACA,
    P_BCB,
    P_FACA,
    P_FBCB,
)
from drake_geom_ros.geometry._proximity.tolerances import SOFT
from drake_geom_ros.geometry.autodiff.witnesses import PoseDerivatives, Side, motion_of, side_of
from drake_geom_ros.geometry.errors import GeometryError
from drake_geom_ros.geometry.queries.query_gradients import pair_evidence, point_evidence
from drake_geom_ros.geometry.queries.query_results import (
    PenetrationResults,
    PointDistanceResults,
    SignedDistanceResults,
)
from drake_geom_ros.math.array_types import Floats

_BORDER = 'a nearest point lies on the border of an edge or face, where its motion has a kink'

_OF_MAP = (
    'nothing is known of the curvature of a sensed map, whose distances alone have derivatives'
)


class PairWitnesses:
    """Derivatives of the witness points and normals of pairs by the motion of frames."""

    def __init__(
        self, results: SignedDistanceResults | PenetrationResults, V_WFs: Floats, number: Any
    ) -> None:
        self._results, self._number = results, number
        self._of = of = pair_evidence(results)
        self._places = places_of(of.scene, of.ids)
        frames = of.scene.frames[self._places]
        self.velocities = V_WFs[frames[:, 0]], V_WFs[frames[:, 1]]

    @cached_property
    def _features(self) -> Features:
        return features_of_pairs(self._of.scene, self._of.ids, self._of.surface_rows)

    def in_bodies(self, k: int) -> dict[str, Any]:
        """Return nhat_BA_W, p_ACa, p_BCb of pair k; raises GeometryError without derivatives."""
        row, motion, _ = self._motion(k)
        scene, (a, b) = self._of.scene, self._places[k]
        return {
            'nhat_BA_W': self._numbers(row, NORMAL, motion.nhat),
            'p_ACa': self._numbers(row, P_ACA, scene.R_WGs[a].T @ motion.of_a),
            'p_BCb': self._numbers(row, P_BCB, scene.R_WGs[b].T @ motion.of_b),
        }

    def in_world(self, k: int) -> dict[str, Any]:
        """Return nhat_BA_W, p_WCa, p_WCb of pair k; raises GeometryError without derivatives."""
        row, motion, (v_a, v_b) = self._motion(k)
        return {
            'nhat_BA_W': self._numbers(row, NORMAL, motion.nhat),
            'p_WCa': self._numbers(row, WITNESS_A, v_a + motion.of_a),
            'p_WCb': self._numbers(row, WITNESS_B, v_b + motion.of_b),
        }

    def _numbers(self, row: Floats, column: int, rates: Floats) -> Any:
        return autodiff_array(row[column : column + 3], rates, self._number)

    def _motion(self, k: int) -> tuple[Floats, PoseDerivatives, tuple[Floats, Floats]]:
        """Return a row, the derivatives of its points and normal, and the material velocities."""
        row, features = self._of.rows[k], self._features
        V_A, V_B = (V_WFs[k] for V_WFs in self.velocities)
        if V_A.shape[1] == 0:  # constants
            none = np.zeros((3, 0))
            return row, PoseDerivatives(none, none, none), (none, none)
        if why := self._why_not(k):
            raise GeometryError(f'The derivatives of points and normal were asked for, but {why}.')
        n, U = row[NORMAL : NORMAL + 3], features.axes[k].T
        v_a, v_b = (
            V[3:] + np.cross(V[:3], row[at : at + 3, None], axis=0)
            for V, at in ((V_A, P_FACA), (V_B, P_FBCB))
        )
        A = side_of(features.numbers[k, 0], U, n, V_A[:3], v_a)
        B = side_of(features.numbers[k, 1], U, n, V_B[:3], v_b)
        return row, motion_of(row[DISTANCE], n, U, A, B), (v_a, v_b)

    def _why_not(self, k: int) -> str:
        """Return why pair k has no derivatives except of the distance, empty if it has."""
        types = self._of.scene.types[self._places[k]].tolist()
        if self._results.is_padded:
            return 'they are of padded geometries, whose distances alone have derivatives'
        if self._results.method[k] == BOUND_ONLY:
            return 'bounds alone answered: ask for another accuracy'
        if max(types) > SOLID:
            return _OF_MAP
        if SOLID in types and HALF_SPACE not in types:
            return (
                "nothing is known of the curvature of a mesh with the property ('mesh', 'solid')"
            )
        if not self._of.rows[k, UNIQUE]:
            return 'the normal is not the only one'
        if not self._results.is_gradient_unique[k]:
            return 'the nearest points, or the normal where bodies touch, are not the only ones'
        return '' if self._features.inside[k].all() else _BORDER


class PointWitnesses:
    """Derivatives of the nearest points and gradients of distances to points."""

    def __init__(
        self, results: PointDistanceResults, V_WFs: Floats, v_Qs: Floats, number: Any
    ) -> None:
        self._results, self._number = results, number
        self._p_WQs, self._scene = point_evidence(results)
        scene = self._scene
        self._places = places_of(scene, results.id_G)
        self._p_FQs = self._p_WQs[results.point_index] - scene.p_WFs[scene.frames[self._places]]
        self.velocities: Floats = V_WFs[scene.frames[self._places]]
        self.of_points: Floats = v_Qs[results.point_index]

    @cached_property
    def _features(self) -> Features:
        """The features of G, as those of the pair (G, G), of which only B's side is used."""
        results, rows = self._results, np.zeros((len(self._places), BATCH_WIDTH))
        rows[:, NORMAL : NORMAL + 3], rows[:, P_BCB : P_BCB + 3] = results.grad_W, results.p_GN
        return features_of_pairs(self._scene, np.column_stack((results.id_G, results.id_G)), rows)

    def nearest(self, k: int) -> dict[str, Any]:
        """Return grad_W and p_GN of answer k; raises GeometryError without derivatives."""
        results, V = self._results, self.velocities[k]
        n, place = results.grad_W[k], self._places[k]
        motion = PoseDerivatives(*3 * [np.zeros((3, 0))])
        if V.shape[1]:
            motion = self._motion(k, n)
        of_N = self._scene.R_WGs[place].T @ motion.of_b
        return {
            'grad_W': autodiff_array(n, motion.nhat, self._number),
            'p_GN': autodiff_array(results.p_GN[k], of_N, self._number),
        }

    def _motion(self, k: int, n: Floats) -> PoseDerivatives:
        results, V, phi = self._results, self.velocities[k], float(self._results.distance[k])
        features, p_FN = self._features, self._p_FQs[k] - phi * n
        why = ''
        if results.is_padded:
            why = 'they are of padded geometries, whose distances alone have derivatives'
        elif self._scene.types[self._places[k]] > SOLID:
            why = _OF_MAP
        elif self._scene.types[self._places[k]] == SOLID:
            why = "nothing is known of the curvature of a mesh with the property ('mesh', 'solid')"
        elif not results.is_grad_W_unique[k]:
            why = 'the gradient is not the only one'
        elif not features.inside[k, 1]:
            why = _BORDER
        U = features.axes[k].T
        none = np.zeros((2, self.of_points.shape[-1]))
        Q = Side(np.zeros((2, 0)), np.zeros((2, 2)), none, U.T @ self.of_points[k])
        v_N = V[3:] + np.cross(V[:3], p_FN[:, None], axis=0)
        G = side_of(features.numbers[k, 1], U, n, V[:3], v_N)
        stiff = np.abs(np.linalg.eigvalsh(phi * np.eye(2) + G.M))
        if not why and not G.D.size and stiff.min() <= SOFT * (abs(phi) + np.linalg.norm(p_FN)):
            why = 'the point lies where the gradient turns at once: on a corner or an axis'
        if why:
            raise GeometryError(f'The derivatives of p_GN and grad_W were asked for, but {why}.')
        return motion_of(phi, n, U, Q, G)
