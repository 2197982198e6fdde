"""closest.png: the scene at its closest moment, with witness points and normal."""

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from drake_geom_ros.geometry import QueryObject, Role
from drake_geom_ros.ros.demo.moment_scene import scene_at
from drake_geom_ros.ros.demo.recording import Approach, Recording
from drake_geom_ros.scene_files import SceneDescription
from drake_geom_ros.sensors import CameraInfo
from drake_geom_ros.viewing.shown_pairs import ReportedPairs
from drake_geom_ros.viewing.snapshot import Camera, camera_for, looking, picture

Floats = NDArray[np.float64]
_WHOLE, _WHOLE_FOV = (960, 840), 0.6  # [pixels], [rad]
_CLOSE, _CLOSE_FOV = (640, 640), 0.25  # little perspective, where a length is shown
_CLOSE_UP = 2.0  # half width of the close-up, in distances of the pair
_CLOSE_UP_LEAST = 0.10  # [m]
_SEE_THROUGH = 0.55
_ELEVATION = 0.3  # of the camera of the close-up, in parts of its distance
_NORMAL = '#b3123a'


def draw_closest(recording: Recording, description: SceneDescription, path: Path) -> None:
    """Draw the whole scene on the left and a close-up of the closest pair on the right.

    Raises ValueError where the recording holds no closest moment.
    """
    moment = recording.approach
    if moment is None:
        raise ValueError('the recording holds no closest moment to draw')
    query, _ = scene_at(description, moment)
    camera = camera_for(query, Role.kProximity, _WHOLE, _WHOLE_FOV)
    figure = Figure(figsize=(14.0, 7.8))
    whole = figure.add_axes((0.01, 0.01, 0.57, 0.85))
    whole.imshow(picture(query, camera, pairs=_pair(moment)))
    close = figure.add_axes((0.6, 0.09, 0.385, 0.69))
    _draw_close(close, query, moment)
    for axes in (whole, close):
        axes.set_xticks([])
        axes.set_yticks([])
    _write_texts(figure, recording, moment)
    figure.savefig(path, dpi=120)


def _draw_close(axes: Any, query: QueryObject, moment: Approach) -> None:
    """Draw the gap from the side, with names of the nearest points and the normal."""
    half = max(_CLOSE_UP * abs(moment.distance), _CLOSE_UP_LEAST)
    middle = 0.5 * (moment.p_WCa + moment.p_WCb)
    start = middle + half / np.tan(0.5 * _CLOSE_FOV) * _side(moment)
    info = CameraInfo(*_CLOSE, _CLOSE_FOV)
    camera = Camera(looking(start.tolist(), middle.tolist()), info)
    axes.imshow(picture(query, camera, see_through=_SEE_THROUGH, pairs=_pair(moment)))
    origin = moment.p_WCb if moment.distance >= 0.0 else moment.p_WCa
    tip = origin + max(abs(moment.distance), 0.2 * half) * moment.nhat_BA_W
    lift = np.array([0.0, 0.0, 0.16 * half])
    a, b, tail, head = camera.pixels(
        np.stack([moment.p_WCa, moment.p_WCb, origin + lift, tip + lift])
    )
    arrow = {'arrowstyle': '-|>', 'color': _NORMAL, 'lw': 2.4, 'mutation_scale': 18}
    axes.annotate('', head, tail, arrowprops=arrow)
    style = {'ha': 'center', 'fontsize': 14, 'annotation_clip': True}
    above = {'xytext': (0, 8), 'textcoords': 'offset points'}
    axes.annotate('normal', 0.5 * (tail + head), color=_NORMAL, **above, **style)
    apart = np.sign(moment.distance) or 1.0
    side = 26.0 * apart * (1.0 if a[0] <= b[0] else -1.0)
    for point, name, way in ((a, 'Ca', -side), (b, 'Cb', side)):
        at = {'xytext': (way, -12), 'textcoords': 'offset points', 'weight': 'bold'}
        axes.annotate(name, point, **at, **style)


def _pair(moment: Approach) -> ReportedPairs:
    """Return the closest pair as the record that pictures show."""
    return ReportedPairs(
        ids=np.array([[moment.id_a, moment.id_b]]),
        distance=np.array([moment.distance]),
        error_bound=np.full(1, np.inf),  # the recording keeps none
        p_WCas=moment.p_WCa[None],
        p_WCbs=moment.p_WCb[None],
        nhat_BA_Ws=moment.nhat_BA_W[None],
    )


def _side(moment: Approach) -> Floats:
    """Return the unit vector to a camera across the normal, so that the gap is seen open."""
    across = np.array([moment.nhat_BA_W[1], -moment.nhat_BA_W[0], 0.0])
    if not np.linalg.norm(across) > 0.0:
        across = np.array([0.0, -1.0, 0.0])
    across /= np.linalg.norm(across)
    # Of the two sides, the one that looks along +y, as from the front of the table.
    way: Floats = (-across if across[1] > 0.0 else across) + [0.0, 0.0, _ELEVATION]
    return way / np.linalg.norm(way)


def _write_texts(figure: Figure, recording: Recording, moment: Approach) -> None:
    kind = 'apart' if moment.distance >= 0.0 else 'deep in each other'
    title = f'Closest approach: {abs(moment.distance) * 1e3:.1f} mm {kind}'
    figure.text(0.02, 0.94, title, fontsize=20, weight='bold')
    time = moment.time - recording.start
    figure.text(0.6, 0.94, f'{time:.2f} s after the first result', fontsize=14)
    for row, (letter, value) in enumerate((('A', moment.id_a), ('B', moment.id_b))):
        text = f'{letter}: {recording.scene[value].full_name}'
        figure.text(0.02, 0.905 - 0.035 * row, text, fontsize=14)
    caption = 'Close-up: the nearest points Ca and Cb,\nand the normal out of B into A'
    figure.text(0.6, 0.80, caption, fontsize=14)
