"""Columns of results as data frames and as tables in notebooks."""

from __future__ import annotations

import html
import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.common.extras import needed_for

Columns = dict[str, NDArray[Any]]

_AXES = 'xyz'
SHOWN_ROWS = 10  # of results in a notebook


class Tabular:
    """Base of results that are columns of equal length."""

    def columns(self) -> Columns:
        """Return the arrays (k, ...) by name; each has a row for each result."""
        raise NotImplementedError

    def to_dataframe(self) -> Any:
        """Return a ``pandas.DataFrame`` with a row for each result.

        An array (k, 3) becomes three columns with the suffixes x, y and z, a wider one columns
        with numbers. Needs pandas, the extra ``dataframes``.
        """
        with needed_for('data frames', 'dataframes'):
            import pandas as pd

        return pd.DataFrame(flat_columns(self.columns()))

    def _repr_html_(self) -> str:
        """Return the nearest results, or the largest surfaces, as a table for notebooks."""
        columns = flat_columns(self.columns())
        which, key = 'nearest', columns.get('distance')
        if 'area' in columns:
            which, key = 'largest', -columns['area']
        elif key is None:
            key = -columns['depth']
        order = np.argsort(key, kind='stable')[:SHOWN_ROWS]
        names = [name for name in columns if not name.startswith(('id_', 'gradient', 'joint_'))]
        shown = {name: [_text(value) for value in columns[name][order]] for name in names}
        return html_table(f'{self!r}; the {which} {len(order)}', shown)


def flat_columns(columns: Columns) -> Columns:
    """Return columns of numbers or texts, one each for the elements of wider arrays."""
    flat: Columns = {}
    for name, values in columns.items():
        if values.ndim == 1:
            flat[name] = values
            continue
        parts = values.reshape(len(values), math.prod(values.shape[1:])).T
        suffixes = _AXES if len(parts) == len(_AXES) else [str(k) for k in range(len(parts))]
        flat |= {f'{name}_{suffix}': part for suffix, part in zip(suffixes, parts, strict=True)}
    return flat


def html_table(caption: str, columns: Mapping[str, Sequence[object]]) -> str:
    """Return a table of columns of equal length, with a row of their names."""
    head = ''.join(f'<th>{html.escape(name)}</th>' for name in columns)
    rows = ''.join(
        '<tr>' + ''.join(f'<td>{html.escape(str(value))}</td>' for value in row) + '</tr>'
        for row in zip(*columns.values(), strict=True)
    )
    return (
        f'<table><caption>{html.escape(caption)}</caption>'
        f'<thead><tr>{head}</tr></thead><tbody>{rows}</tbody></table>'
    )


def _text(value: Any) -> str:
    return f'{value:.6g}' if isinstance(value, float | np.floating) else str(value)
