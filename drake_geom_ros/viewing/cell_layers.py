"""Layers of sensed maps: cells, what is beside bodies, and what bodies hide from a sensor."""

from __future__ import annotations

from typing import NamedTuple

from drake_geom_ros.math.array_types import Floats
from drake_geom_ros.viewing.looks import Colour

# Kinds of layers, as the namespaces of ~/markers call them, and what they show.
CELL_LAYERS = {
    'obstacles': 'cells',
    'shell': 'seen beside bodies',
    'shadow': 'hidden by bodies',
}


class CellLayer(NamedTuple):
    """Cubes of one kind that the map of a source shows; replaced as a whole when they change."""

    source: str
    kind: str  # one of CELL_LAYERS
    centres: Floats  # (n, 3) [m] in World
    wxyz: Floats  # (4,) orientation of all cubes
    edge: float  # [m]
    colour: Colour

    @property
    def is_seen(self) -> bool:
        """True if the layer has cubes."""
        return len(self.centres) > 0

    @property
    def key(self) -> tuple[str, str]:
        """The source and the kind."""
        return self.source, self.kind
