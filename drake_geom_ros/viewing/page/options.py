"""Options of a page: what is asked, and what is drawn of the scene."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

from drake_geom_ros.geometry import ACCURACY_LEVELS, GeometryError, accuracy_of
from drake_geom_ros.viewing.cell_layers import CELL_LAYERS
from drake_geom_ros.viewing.looks import LAYERS

LEVELS: tuple[str, ...] = tuple(ACCURACY_LEVELS)
_FARTHEST = 1000.0  # [m]
_MOST_NAMES = 1000  # hidden sources


class CommandError(ValueError):
    """A browser asked for something that the page cannot do."""


@dataclass(frozen=True)
class ViewOptions:
    """Options that all browsers of a page share.

    ``max_distance`` [m] and ``accuracy`` are those of the query; the others say what is drawn.
    ``hidden`` are names of sources that are not drawn, ``hidden_cells`` kinds of layers of maps.
    """

    max_distance: float = 0.1
    accuracy: str = 'exact'
    layers: frozenset[str] = frozenset({'proximity'})
    hidden: frozenset[str] = frozenset()
    hidden_cells: frozenset[str] = frozenset()
    names: bool = False
    frames: bool = False
    normals: bool = True
    bounds: bool = False
    contacts: bool = False
    grid: bool = False

    def changed(self, name: str, value: Any) -> ViewOptions:
        """Return options with another value of one; CommandError, naming what is allowed."""
        if name == 'max_distance':
            return replace(self, max_distance=number(value, 'max_distance [m]', 0.0, _FARTHEST))
        if name == 'accuracy':
            try:
                return replace(self, accuracy=str(accuracy_of(text(value, 'accuracy'))))
            except GeometryError as error:
                raise CommandError(str(error)) from None
        if name == 'layers':
            return replace(self, layers=words(value, name, tuple(LAYERS.values())))
        if name == 'hidden_cells':
            return replace(self, hidden_cells=words(value, name, tuple(CELL_LAYERS)))
        if name == 'hidden':
            return replace(self, hidden=words(value, name))
        if name in ('names', 'frames', 'normals', 'bounds', 'contacts', 'grid'):
            switched: dict[str, Any] = {name: flag(value, name)}
            return replace(self, **switched)
        raise CommandError(f'{name!r} is no option; there are {", ".join(asdict(self))}')

    def plain(self) -> dict[str, Any]:
        """Return the options as JSON has them."""
        return {
            name: sorted(value) if isinstance(value, frozenset) else value
            for name, value in asdict(self).items()
        }


def number(value: Any, what: str, low: float = -math.inf, high: float = math.inf) -> float:
    """Return a finite number within limits."""
    is_number = isinstance(value, int | float) and not isinstance(value, bool)
    if not is_number or not math.isfinite(value) or not low <= value <= high:
        raise CommandError(f'{what} must be a number from {low:g} to {high:g}, not {value!r}')
    return float(value)


def flag(value: Any, what: str) -> bool:
    """Return true or false."""
    if not isinstance(value, bool):
        raise CommandError(f'{what} must be true or false, not {value!r}')
    return value


def text(value: Any, what: str) -> str:
    """Return a text."""
    if not isinstance(value, str):
        raise CommandError(f'{what} must be a text, not {value!r}')
    return value


def words(value: Any, what: str, allowed: Sequence[str] = ()) -> frozenset[str]:
    """Return a set of texts, of the allowed ones if there are some."""
    if not isinstance(value, list) or len(value) > _MOST_NAMES:
        raise CommandError(f'{what} must be a list of texts, not {value!r}')
    chosen = frozenset(text(each, what) for each in value)
    if allowed and not chosen <= set(allowed):
        raise CommandError(f'{what} must be of {", ".join(allowed)}, not {value!r}')
    return chosen


def vector(value: Any, what: str, size: int) -> list[float]:
    """Return finite numbers of a list of a size."""
    if not isinstance(value, list) or len(value) != size:
        raise CommandError(f'{what} must be {size} numbers, not {value!r}')
    return [number(each, what) for each in value]
