"""closest.png: the scene at its closest moment, with witness points and normal."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle
from mpl_toolkits.mplot3d.art3d import Poly3DCollection
from numpy.typing import NDArray

from drake_geom_ros.client.scene_table import Geometry
from drake_geom_ros.ros.demo.recording import Approach, Recording
from drake_geom_ros.ros.demo.surfaces import faces_of

Floats = NDArray[np.float64]
_ROBOT_COLOURS = ('#3f7fbf', '#d9822b')
_OBJECTS, _SCENERY = '#5a9e5a', '#cfc9be'
_NORMAL, _WITNESS, _FRAME = '#b3123a', '#111111', '#888888'
_WINDOW = (0.585, 0.06, 0.40, 0.718)  # left, bottom, width and height of the close-up
_LIGHT = np.array([0.35, -0.55, 0.76])
_ELEVATION = 18.0  # [degrees]
_CLOSE_UP = 2.0  # half width of the close-up, in distances of the pair
_CLOSE_UP_LEAST = 0.10  # [m]


def draw_closest(recording: Recording, path: Path) -> None:
    """Draw the whole scene on the left and a close-up of the closest pair on the right.

    Raises ValueError where the recording holds no closest moment.
    """
    moment = recording.approach
    if moment is None:
        raise ValueError('the recording holds no closest moment to draw')
    figure = Figure(figsize=(14.0, 7.8))
    azimuth = _azimuth(moment)
    whole = figure.add_axes((0.01, 0.01, 0.56, 0.84), projection='3d', computed_zorder=False)
    close = figure.add_axes(_WINDOW, projection='3d', computed_zorder=False)
    # No perspective where a length is to be read off.
    close.set_proj_type('ortho')
    # A body without a pose is nowhere, and not at the world's origin.
    geometries = [
        geometry
        for geometry in recording.scene.geometries.values()
        if geometry.anchored or geometry.own_frame in moment.X_WFs
    ]
    _draw_shapes(whole, recording, moment, geometries, lambda geometry: 1.0)
    pair = (recording.scene[moment.id_a], recording.scene[moment.id_b])
    bodies = {geometry.body for geometry in pair}
    near = [g for g in geometries if g.body in bodies]
    _draw_shapes(
        close, recording, moment, near, lambda geometry: 0.45 if geometry in pair else 0.12
    )
    _draw_witnesses(whole, moment, size=45, line=1.6)
    _draw_witnesses(close, moment, size=70, line=2.4)
    _draw_normal(close, moment)
    # The bodies of the close-up go on outside: a frame shows that it is a window, and no cut.
    figure.add_artist(Rectangle(_WINDOW[:2], *_WINDOW[2:], fill=False, ec=_FRAME, lw=1.2))
    _label_close(close, moment)
    _frame_whole(whole, moment, geometries, azimuth)
    _frame_close(close, moment, azimuth)
    _write_texts(figure, recording, moment, pair)
    figure.savefig(path, dpi=120)


def _draw_shapes(
    axes: Any,
    recording: Recording,
    moment: Approach,
    geometries: list[Geometry],
    opacity: Callable[[Geometry], float],
) -> None:
    """Draw all faces as one collection, so that they are sorted by depth among each other."""
    faces, colours = [], []
    for geometry in geometries:
        shape = faces_of(geometry.shape_type, geometry.dimensions)
        X_WG = geometry.X_WG(moment.X_WFs)
        corners = [face @ X_WG[:3, :3].T + X_WG[:3, 3] for face in shape]
        faces += corners
        colours += [
            (*_shaded(_colour(geometry, recording.robots), face), opacity(geometry))
            for face in corners
        ]
    # Opaque faces get an edge of their own colour, which closes the cracks between them.
    edges = colours if all(colour[3] == 1.0 for colour in colours) else 'none'
    axes.add_collection3d(
        Poly3DCollection(faces, facecolors=colours, edgecolors=edges, linewidths=0.3, zorder=1)
    )


def _colour(geometry: Geometry, robots: tuple[str, ...]) -> str:
    if geometry.source in robots:
        return _ROBOT_COLOURS[robots.index(geometry.source) % len(_ROBOT_COLOURS)]
    return _SCENERY if geometry.anchored else _OBJECTS


def _shaded(colour: str, face: Floats) -> Floats:
    """Return a colour as a lamp from above shows it on a face (k, 3)."""
    # The longer of two diagonals' products: a face may be a triangle with two equal corners.
    normal = np.cross(face[2] - face[0], face[3] - face[1])
    length = np.linalg.norm(normal)
    lit = 0.0 if length == 0.0 else float(normal @ _LIGHT) / length
    return np.array(to_rgb(colour)) * (0.66 + 0.34 * lit)


def _draw_witnesses(axes: Any, moment: Approach, size: float, line: float) -> None:
    """Draw both witness points and the line between them."""
    ends = np.stack([moment.p_WCa, moment.p_WCb])
    axes.plot(*ends.T, color=_WITNESS, lw=line, zorder=3)
    axes.scatter(*ends.T, s=size, color='white', edgecolors=_WITNESS, linewidths=1.4,
                 depthshade=False, zorder=4)  # fmt: skip


def _draw_normal(axes: Any, moment: Approach) -> None:
    """Draw the normal out of B into A between the bodies, a little above the witness points."""
    start = moment.p_WCb if moment.distance >= 0.0 else moment.p_WCa
    start = start + np.array([0.0, 0.0, 0.16 * _half_width(moment)])
    axes.quiver(*start, *(abs(moment.distance) * moment.nhat_BA_W), color=_NORMAL, lw=2.4,
                arrow_length_ratio=0.3, zorder=5)  # fmt: skip


def _label_close(axes: Any, moment: Approach) -> None:
    """Name the witness points and write the distance between them."""
    lift = np.array([0.0, 0.0, 0.07 * _half_width(moment)])
    out = 0.12 * _half_width(moment) * moment.nhat_BA_W * np.sign(moment.distance)
    style = {'ha': 'center', 'zorder': 6}
    middle = (moment.p_WCa + moment.p_WCb) / 2
    axes.text(*(middle - 2.6 * lift), f'{moment.distance * 1e3:.1f} mm', fontsize=16, **style)
    axes.text(*(middle + 3.2 * lift), 'normal', fontsize=14, color=_NORMAL, **style)
    axes.text(*(moment.p_WCa + out), 'Ca', fontsize=16, weight='bold', va='center', **style)
    axes.text(*(moment.p_WCb - out), 'Cb', fontsize=16, weight='bold', va='center', **style)


def _azimuth(moment: Approach) -> float:
    """Return the view's azimuth [degrees]: from the side, so that the gap is seen open."""
    across = float(np.degrees(np.arctan2(moment.nhat_BA_W[1], moment.nhat_BA_W[0])))
    side = across - 90.0
    # Of the two sides the one that looks along +y, as from the front of the table.
    return side if np.sin(np.radians(side)) <= 0.0 else side + 180.0


def _frame_whole(axes: Any, moment: Approach, geometries: list[Geometry], azimuth: float) -> None:
    centres = np.array([g.X_WG(moment.X_WFs)[:3, 3] for g in geometries if g.dimensions])
    low, high = centres.min(axis=0), centres.max(axis=0)
    _frame(axes, (low + high) / 2, 0.94 * np.max(high - low) / 2, azimuth + 18.0, 1.3)


def _frame_close(axes: Any, moment: Approach, azimuth: float) -> None:
    _frame(axes, (moment.p_WCa + moment.p_WCb) / 2, _half_width(moment), azimuth, 1.45)


def _half_width(moment: Approach) -> float:
    return max(_CLOSE_UP * abs(moment.distance), _CLOSE_UP_LEAST)


def _frame(axes: Any, centre: Floats, half: float, azimuth: float, zoom: float) -> None:
    """Show a cube of a given half width, without the box of axes around it."""
    for set_limits, middle in zip(
        (axes.set_xlim, axes.set_ylim, axes.set_zlim), centre, strict=True
    ):
        set_limits(middle - half, middle + half)
    axes.set_box_aspect((1, 1, 1), zoom=zoom)
    axes.view_init(elev=_ELEVATION, azim=azimuth)
    axes.set_axis_off()


def _write_texts(
    figure: Figure, recording: Recording, moment: Approach, pair: tuple[Geometry, Geometry]
) -> None:
    kind = 'apart' if moment.distance >= 0.0 else 'deep in each other'
    title = f'Closest approach: {abs(moment.distance) * 1e3:.1f} mm {kind}'
    time = moment.time - recording.start
    figure.text(0.02, 0.94, title, fontsize=20, weight='bold')
    figure.text(0.44, 0.94, f'{time:.2f} s after the first result', fontsize=14)
    for row, (letter, geometry) in enumerate(zip('AB', pair, strict=True)):
        colour = _colour(geometry, recording.robots)
        text = f'{letter}: {geometry.full_name}'
        figure.text(0.02, 0.895 - 0.04 * row, text, fontsize=14, color=colour, weight='bold')
    caption = 'Close-up: the nearest points Ca and Cb,\nand the normal out of B into A'
    figure.text(_WINDOW[0], 0.80, caption, fontsize=14)
