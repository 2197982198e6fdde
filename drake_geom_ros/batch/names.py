"""The names of geometries, which results know beside their ids."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry import GeometryError

Indices = NDArray[np.int64]


class Names:
    """The names of geometries, ``source::frame/geometry``, by the values of their ids."""

    _known: Mapping[int, str] = {}

    def names_of(self, ids: Indices) -> NDArray[np.str_]:
        """Return the names of id values (k,), empty where there is no geometry.

        Raises GeometryError for what is no geometry of the scene that was asked.
        """
        values, places = np.unique(ids, return_inverse=True)
        unknown = [value for value in values.tolist() if value and value not in self._known]
        if unknown:
            raise GeometryError(f'{unknown[0]} is the id of no geometry that these results know')
        told = [self._known[value] if value else '' for value in values.tolist()]
        return np.array(told, dtype=np.str_)[places.reshape(np.shape(ids))]


class PairNames(Names):
    """The names of the pairs of results."""

    id_A: Indices
    id_B: Indices

    @property
    def name_A(self) -> NDArray[np.str_]:
        """The names (k,) of the first geometries, empty where there is no pair."""
        return self.names_of(self.id_A)

    @property
    def name_B(self) -> NDArray[np.str_]:
        """The names (k,) of the second geometries, empty where there is no pair."""
        return self.names_of(self.id_B)
