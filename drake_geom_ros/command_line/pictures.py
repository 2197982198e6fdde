"""Writers of rendered images, as data for programs and as pictures for people."""

from __future__ import annotations

import csv
import importlib.util
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.common.whole_files import check_outputs, whole_file
from drake_geom_ros.geometry import GeometryError, RenderedImages, RenderLabel

_LIBRARIES = {'PIL': 'pillow', 'matplotlib': 'matplotlib'}
_MILLIMETRES = 1000.0  # in a metre
_LARGEST = 2**16 - 1
_DOTS = 100  # pixels an inch, in pictures for people
_MOST_NAMES = 24  # in the legend of a picture
_NO_COLOUR = (0.93, 0.93, 0.93)

Legend = dict[int, list[str]]


def check_libraries() -> None:
    """Raise GeometryError, naming the missing packages, if pictures cannot be written."""
    missing = [pip for name, pip in _LIBRARIES.items() if not importlib.util.find_spec(name)]
    if missing:
        raise GeometryError(
            f'pictures need {" and ".join(missing)}: pip install {" ".join(missing)}, or this '
            "package with its extra 'pictures'"
        )


def write_all(
    images: RenderedImages, legend: Legend, path: Path, inputs: Sequence[Path] = ()
) -> list[Path]:
    """Write the rendered images as ``PATH_color.png`` and so on; return the files.

    Raises FileExistsError, before any is written, if one is a file of ``inputs``.
    """
    names: list[str] = []
    if images.color is not None:
        names.append('color.png')
    if images.depth is not None:
        names += ['depth.png', 'depth_map.png']
    if images.label is not None:
        names += ['label.png', 'label_map.png', 'label_legend.csv']
    files = {name: path.with_name(f'{path.name}_{name}') for name in names}
    for file in files.values():
        check_outputs({'the image': file}, inputs)
    if images.color is not None:
        _write_png(images.color.data, files['color.png'])
    if images.depth is not None:
        depths = images.depth.data[..., 0]
        _write_png(millimetres(depths), files['depth.png'])
        _write_depth_map(depths, files['depth_map.png'])
    if images.label is not None:
        labels = images.label.data[..., 0]
        _write_png(labels.astype(np.uint16), files['label.png'])
        _write_label_map(labels, legend, files['label_map.png'])
        _write_legend(labels, legend, files['label_legend.csv'])
    return list(files.values())


def millimetres(depths: NDArray[np.float32]) -> NDArray[np.uint16]:
    """Return depths [m] as whole millimetres, 0 where unknown, as 16UC1 images of ROS."""
    has_depth = np.isfinite(depths) & (depths * _MILLIMETRES < _LARGEST)
    return np.rint(np.where(has_depth, depths, 0.0) * _MILLIMETRES).astype(np.uint16)


def _write_png(pixels: NDArray[Any], path: Path) -> None:
    from PIL import Image

    with whole_file(path, 'wb') as file:
        Image.fromarray(pixels).save(file, 'PNG')


def _figure(shape: tuple[int, ...]) -> tuple[Any, Any]:
    """Return an off-screen figure, and axes for an image of (rows, columns)."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    width = 6.4
    figure = Figure(figsize=(width + 2.0, width * shape[0] / shape[1] + 0.6), dpi=_DOTS)
    FigureCanvasAgg(figure)
    axes = figure.add_subplot()
    axes.set_axis_off()
    return figure, axes


def _save(figure: Any, path: Path) -> None:
    with whole_file(path, 'wb') as file:
        figure.savefig(file, format='png', bbox_inches='tight')


def _write_depth_map(depths: NDArray[np.float32], path: Path) -> None:
    """Write depths as colours with a scale; pixels without a depth stay grey."""
    from matplotlib.colors import LogNorm

    figure, axes = _figure(depths.shape)
    has_depth = np.isfinite(depths) & (depths > 0.0)
    shown = np.ma.masked_array(depths, ~has_depth)
    axes.imshow(np.full((*depths.shape, 3), _NO_COLOUR), interpolation='nearest')
    if has_depth.any():
        # Logarithmic, since near bodies differ by less than the floor does towards the horizon.
        image = axes.imshow(shown, norm=LogNorm(), cmap='viridis_r', interpolation='nearest')
        figure.colorbar(image, ax=axes, label='depth [m]', fraction=0.046)
    _save(figure, path)


def _present(labels: NDArray[np.int16]) -> list[int]:
    """Return the labels in an image, without the empty one, by descending pixel count."""
    values, counts = np.unique(labels, return_counts=True)
    order = np.argsort(-counts, kind='stable')
    return [int(values[k]) for k in order if values[k] != int(RenderLabel.kEmpty)]


def _write_label_map(labels: NDArray[np.int16], legend: Legend, path: Path) -> None:
    """Write labels as colours, with a legend of those with most pixels."""
    from matplotlib import colormaps
    from matplotlib.patches import Patch

    figure, axes = _figure(labels.shape)
    pixels = np.full((*labels.shape, 3), _NO_COLOUR)
    patches = []
    for place, label in enumerate(_present(labels)):
        colour = colormaps['tab20'](place % 20)[:3]
        pixels[labels == label] = colour
        names = ', '.join(legend.get(label, [])) or 'without a name'
        patches.append(Patch(color=colour, label=f'{label}: {names}'))
    axes.imshow(pixels, interpolation='nearest')
    if patches:
        shown = patches[:_MOST_NAMES]
        axes.legend(
            handles=shown, loc='center left', bbox_to_anchor=(1.01, 0.5), fontsize=7, frameon=False
        )
    _save(figure, path)


def _write_legend(labels: NDArray[np.int16], legend: Legend, path: Path) -> None:
    """Write label, geometry and pixel count, one line for each geometry of the role."""
    values, counts = np.unique(labels, return_counts=True)
    pixels = dict(zip(values.tolist(), counts.tolist(), strict=True))
    with whole_file(path, newline='') as file:
        writer = csv.writer(file, lineterminator='\n')
        writer.writerow(['label', 'geometry', 'pixels_of_label'])
        for label, names in sorted(legend.items()):
            writer.writerows([label, name, pixels.get(label, 0)] for name in names)
