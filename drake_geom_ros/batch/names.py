"""Names of geometries in results, by their ids."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry import GeometryError
from drake_geom_ros.math.array_types import Indices


class Names:
    """Base of results with the names of geometries, ``source::frame/geometry``, by id values."""

    _name_of: Mapping[int, str] = {}

    def names_of(self, ids: Indices) -> NDArray[np.str_]:
        """Return the names of id values (k,), empty for 0, which is no geometry.

        Raises GeometryError for an id that is not in the scene of the results.
        """
        values, places = np.unique(ids, return_inverse=True)
        unknown = [value for value in values.tolist() if value and value not in self._name_of]
        if unknown:
            raise GeometryError(f'{unknown[0]} is the id of no geometry that these results know')
        names = [self._name_of[value] if value else '' for value in values.tolist()]
        return np.array(names, dtype=np.str_)[places.reshape(np.shape(ids))]


class PairNames(Names):
    """Base of results with the names of pairs."""

    id_A: Indices
    id_B: Indices

    @property
    def name_A(self) -> NDArray[np.str_]:
        """The names (k,) of the first geometries, empty without a pair."""
        return self.names_of(self.id_A)

    @property
    def name_B(self) -> NDArray[np.str_]:
        """The names (k,) of the second geometries, empty without a pair."""
        return self.names_of(self.id_B)
