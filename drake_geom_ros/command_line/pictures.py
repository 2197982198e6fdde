"""Images as files: what programs read, and what people look at."""

from __future__ import annotations

import csv
import importlib.util
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry import GeometryError, RenderedImages, RenderLabel

_LIBRARIES = {'PIL': 'pillow', 'matplotlib': 'matplotlib'}
_MILLIMETRE = 1000.0  # of them in a metre
_LARGEST = 2**16 - 1
_DOTS = 100  # pixels an inch, in pictures for people
_MOST_NAMES = 24  # in the legend of a picture
_NO_COLOUR = (0.93, 0.93, 0.93)

Legend = dict[int, list[str]]


def check_libraries() -> None:
    """Raise GeometryError, naming what is missing, where pictures cannot be written."""
    missing = [pip for name, pip in _LIBRARIES.items() if not importlib.util.find_spec(name)]
    if missing:
        raise GeometryError(
            f'pictures need {" and ".join(missing)}: pip install {" ".join(missing)}, or this '
            "package with its extra 'pictures'"
        )


def write_all(images: RenderedImages, legend: Legend, folder: Path, name: str) -> list[Path]:
    """Write the images that are there as ``NAME_color.png`` and so on; return the files."""
    written = []
    if images.color is not None:
        written.append(folder / f'{name}_color.png')
        _write_png(images.color.data, written[-1])
    if images.depth is not None:
        depths = images.depth.data[..., 0]
        written += [folder / f'{name}_depth.png', folder / f'{name}_depth_map.png']
        _write_png(millimetres(depths), written[-2])
        _write_depth_map(depths, written[-1])
    if images.label is not None:
        labels = images.label.data[..., 0]
        files = ('label.png', 'label_map.png', 'label_legend.csv')
        written += [folder / f'{name}_{file}' for file in files]
        _write_png(labels.astype(np.uint16), written[-3])
        _write_label_map(labels, legend, written[-2])
        _write_legend(labels, legend, written[-1])
    return written


def millimetres(depths: NDArray[np.float32]) -> NDArray[np.uint16]:
    """Return depths [m] as whole millimetres, 0 where none is told: as 16UC1 has it in ROS."""
    told = np.isfinite(depths) & (depths * _MILLIMETRE < _LARGEST)
    return np.rint(np.where(told, depths, 0.0) * _MILLIMETRE).astype(np.uint16)


def _write_png(pixels: NDArray[Any], path: Path) -> None:
    from PIL import Image

    Image.fromarray(pixels).save(path)


def _figure(shape: tuple[int, ...]) -> tuple[Any, Any]:
    """Return a figure without a screen, and the axes of an image of (rows, columns)."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    width = 6.4
    figure = Figure(figsize=(width + 2.0, width * shape[0] / shape[1] + 0.6), dpi=_DOTS)
    FigureCanvasAgg(figure)
    axes = figure.add_subplot()
    axes.set_axis_off()
    return figure, axes


def _write_depth_map(depths: NDArray[np.float32], path: Path) -> None:
    """Write depths as colours with a scale; what is told no depth of stays grey."""
    from matplotlib.colors import LogNorm

    figure, axes = _figure(depths.shape)
    told = np.isfinite(depths) & (depths > 0.0)
    shown = np.ma.masked_array(depths, ~told)
    axes.imshow(np.full((*depths.shape, 3), _NO_COLOUR), interpolation='nearest')
    if told.any():
        # By orders: what is near differs by less than what the floor does towards the horizon.
        image = axes.imshow(shown, norm=LogNorm(), cmap='viridis_r', interpolation='nearest')
        figure.colorbar(image, ax=axes, label='depth [m]', fraction=0.046)
    figure.savefig(path, bbox_inches='tight')


def _present(labels: NDArray[np.int16]) -> list[int]:
    """Return the labels that an image shows, but that of nothing, most pixels first."""
    values, counts = np.unique(labels, return_counts=True)
    order = np.argsort(-counts, kind='stable')
    return [int(values[k]) for k in order if values[k] != int(RenderLabel.kEmpty)]


def _write_label_map(labels: NDArray[np.int16], legend: Legend, path: Path) -> None:
    """Write labels as colours, with the names of those that take most pixels."""
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
    figure.savefig(path, bbox_inches='tight')


def _write_legend(labels: NDArray[np.int16], legend: Legend, path: Path) -> None:
    """Write label, geometry and pixels, a line for each geometry that could be seen."""
    values, counts = np.unique(labels, return_counts=True)
    pixels = dict(zip(values.tolist(), counts.tolist(), strict=True))
    with path.open('w', encoding='utf-8', newline='') as file:
        writer = csv.writer(file, lineterminator='\n')
        writer.writerow(['label', 'geometry', 'pixels_of_label'])
        for label, names in sorted(legend.items()):
            writer.writerows([label, name, pixels.get(label, 0)] for name in names)
