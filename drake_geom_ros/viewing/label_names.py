"""Names of bodies written into a label image."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry import GeometryId, SceneGraphInspector

_LEAST = 12.0  # [pixels] from the rim of an area to its middle, for a name to fit


def draw_labels(
    axes: Any,
    labels: NDArray[np.int16],
    legend: Mapping[GeometryId, int],
    inspector: SceneGraphInspector,
) -> None:
    """Draw a label image (h, w) on axes of matplotlib, with a name in each area that has room.

    ``legend`` is that of ``render_legend``.
    """
    # scipy.ndimage takes long to import, and only pictures need it.
    from scipy.ndimage import distance_transform_edt

    present, places = np.unique(labels, return_inverse=True)
    places = places.reshape(labels.shape)
    axes.imshow(places % 20, cmap='tab20', interpolation='nearest', vmin=0, vmax=19)
    for place, number in enumerate(present.tolist()):
        # The name stands where the rim of the area is farthest.
        inner = distance_transform_edt(np.pad(places == place, 1))[1:-1, 1:-1]
        row, column = np.unravel_index(inner.argmax(), inner.shape)
        geometries = [geometry for geometry, label in legend.items() if label == number]
        if not geometries or inner[row, column] < _LEAST:
            continue
        name = inspector.GetName(geometries[0])
        if name.startswith('collision'):  # of a link, whose name says more
            name = inspector.GetName(inspector.GetFrameId(geometries[0]))
        box = {'boxstyle': 'round,pad=0.15', 'fc': 'white', 'ec': 'none', 'alpha': 0.75}
        axes.text(column, row, name, ha='center', va='center', fontsize=9, bbox=box)
