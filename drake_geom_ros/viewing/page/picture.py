"""Picture of a moment: batches of shapes, pairs, names and frames as nodes of viser's scene.

Names of the scene are only used as texts of labels; nodes are named by numbers.
"""

from __future__ import annotations

import importlib
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

import numpy as np

from drake_geom_ros.math.array_types import Floats
from drake_geom_ros.math.batched import quaternions_from_rotations
from drake_geom_ros.viewing.batches import SurfaceBatch, batches_of
from drake_geom_ros.viewing.cell_layers import CellLayer
from drake_geom_ros.viewing.extents import extent_of
from drake_geom_ros.viewing.looks import LAYERS, NORMAL_LENGTH, PAIR_COLOURS, Colour
from drake_geom_ros.viewing.page.ghosts import Ghosts
from drake_geom_ros.viewing.page.options import ViewOptions
from drake_geom_ros.viewing.patches import Patches, colours_of
from drake_geom_ros.viewing.rules import COLOURS, rows_of_level
from drake_geom_ros.viewing.scaled_surfaces import CUBE
from drake_geom_ros.viewing.shown_pairs import ReportedPairs, in_words
from drake_geom_ros.viewing.shown_scene import ShownGeometries, ShownMoment

# Lines of the nearest pairs; each costs a browser without a GPU as much as a body.
_MOST_PAIRS = 1000
MOST_NAMES = 300  # labels: a browser lays each of them out
_THIN, _THICK = 2.0, 6.0  # [pixels]
_MANY = 100  # copies of a surface; of more, distant ones are drawn by fewer triangles
_SMALL = 0.8  # times viser's default size of labels
_POINT_SIZE = 0.012  # [m]
_SHADES = 256  # of the colours of pressures
_AXIS_LENGTH, _AXIS_RADIUS = 0.08, 0.002  # [m]


def _bytes(name: str) -> tuple[int, ...]:
    """Return a colour of pairs as integers from 0 to 255."""
    return _bytes_of(PAIR_COLOURS[name])


def _bytes_of(colour: Colour) -> tuple[int, ...]:
    return tuple(round(255.0 * part) for part in colour[:3])


_CONTACT, _SELECTED = _bytes('contacts'), (160, 0, 255)


class Picture:
    """Drawer of moments into viser's scene, which sends only changes."""

    def __init__(
        self,
        scene: Any,
        chosen: Callable[[int], None],
        progress: Callable[[int, int], None] = lambda done, all: None,
    ) -> None:
        """Draw into ``scene``; a click calls ``chosen(value)`` with the geometry's id value.

        ``progress(done, all)`` is called with the number of drawn looks of a new scene.
        """
        self._scene = scene
        self._chosen = chosen
        self._progress = progress
        self._geometries: ShownGeometries | None = None
        self._batches: list[_ShownBatch] = []
        self._names: dict[int, Any] = {}
        self.troubles: list[str] = []
        self._layers = {
            name: scene.add_frame(f'/{name}', show_axes=False) for name in LAYERS.values()
        }
        self._lines = {
            'contacts': _Lines(scene, 'contacts', _CONTACT, _THICK),
            'normals': _Lines(scene, 'normals', _bytes('normals'), _THIN),
            'distances': _Lines(scene, 'distances', _bytes('distances'), _THIN),
            'selected': _Lines(scene, 'selected', _SELECTED, _THICK),
        }
        self._of_rules = {
            level: _Lines(scene, f'rules/{level.name.lower()}', colour, _THICK)
            for level, colour in COLOURS.items()
        }
        self._points = scene.add_point_cloud(
            '/pairs/points',
            np.zeros((1, 3)),
            _CONTACT,
            point_size=_POINT_SIZE,
            point_shape='circle',
            precision='float32',
            visible=False,
        )
        self._surfaces = _PressureSurfaces(scene)
        self._ghosts = Ghosts(scene)
        self._selected_label = _Label(scene, '/pairs/selected_label')
        self._axes: Any = None
        self._grid: Any = None
        self._hidden: frozenset[str] = frozenset()
        self._marked: frozenset[int] = frozenset()
        self._cells: dict[tuple[str, str], tuple[CellLayer, Any]] = {}
        self._numbers: dict[tuple[str, str], int] = {}  # in the names of their nodes

    def show(
        self,
        moment: ShownMoment,
        options: ViewOptions,
        marked: Sequence[int] = (),
        selected: ReportedPairs | None = None,
    ) -> None:
        """Draw a moment; ``marked`` bodies (id values) stand out, and so does one pair."""
        if moment.geometries is not self._geometries or options.hidden != self._hidden:
            self._begin(moment.geometries, options.hidden)
        for name, layer in self._layers.items():
            layer.visible = name in options.layers
        if frozenset(marked) != self._marked:
            self._marked = frozenset(marked)
            for shown in self._batches:
                shown.mark(self._marked)
        for shown in self._batches:
            if shown.batch.layer in options.layers:
                shown.pose(moment)
        self._show_grid(moment, options)
        pairs = self._of_drawn_bodies(moment)
        self._show_pairs(pairs.rows(slice(_MOST_PAIRS)), options)
        for level, lines in self._of_rules.items():
            rows = np.array(rows_of_level(moment.rules, moment.pairs, level), dtype=np.int64)
            lines.show(moment.pairs.rows(rows).segments())
        self._surfaces.show(moment.patches)
        self._ghosts.show(moment, options)
        self._show_selected(ReportedPairs.none() if selected is None else selected, options)
        self._show_names(moment, options)
        self._show_frames(moment, options)

    def _of_drawn_bodies(self, moment: ShownMoment) -> ReportedPairs:
        """Return the pairs of which both bodies are drawn."""
        if not self._hidden:
            return moment.pairs
        names = moment.geometries.names
        hidden = [v for v, name in names.items() if name.partition('::')[0] in self._hidden]
        return moment.pairs.rows(np.flatnonzero(~np.isin(moment.pairs.ids, hidden).any(axis=1)))

    def _show_grid(self, moment: ShownMoment, options: ViewOptions) -> None:
        if options.grid and self._grid is None:
            extent = extent_of(moment)
            low = 0.0 if extent is None else float(extent.low[2])
            self._grid = self._scene.add_grid(
                '/grid',
                infinite_grid=True,
                cell_size=0.1,
                section_size=1.0,
                fade_distance=30.0,
                position=(0.0, 0.0, min(0.0, low)),
            )
        if self._grid is not None:
            self._grid.visible = options.grid

    def show_cells(self, layers: Sequence[CellLayer]) -> None:
        """Draw layers of sensed maps instead of those before; unchanged ones are not sent."""
        wanted = {layer.key: layer for layer in layers if len(layer.centres)}
        for key in [
            key for key, (layer, _) in self._cells.items() if wanted.get(key) is not layer
        ]:
            self._cells.pop(key)[1].remove()
        for key, layer in wanted.items():
            self._numbers.setdefault(key, len(self._numbers))
            if key not in self._cells:
                self._cells[key] = layer, self._cubes(layer)

    def _cubes(self, layer: CellLayer) -> Any:
        count, alpha = len(layer.centres), layer.colour[3]
        return self._scene.add_batched_meshes_simple(
            f'/cells/{self._numbers[layer.key]}',
            vertices=CUBE.vertices,
            faces=CUBE.triangles,
            batched_wxyzs=np.tile(layer.wxyz, (count, 1)),
            batched_positions=layer.centres,
            batched_scales=np.full(count, layer.edge),
            batched_colors=np.tile(_bytes_of(layer.colour), (count, 1)),
            opacity=None if alpha >= 1.0 else alpha,
            flat_shading=True,
            lod='off',
            cast_shadow=False,
            receive_shadow=False,
        )

    def _begin(self, geometries: ShownGeometries, hidden: frozenset[str]) -> None:
        """Draw other geometries from now on, those of hidden sources left out."""
        for shown in self._batches:
            shown.handle.remove()
        for handle in self._names.values():
            handle.remove()
        self._names.clear()
        looks = [look for look in geometries.looks if look.name.partition('::')[0] not in hidden]
        batches = batches_of(
            looks, geometries.row_of, lambda done: self._progress(done, len(looks))
        )
        self._batches = [
            _ShownBatch(self._scene, number, batch, self._chosen)
            for number, batch in enumerate(batches.batches)
        ]
        self.troubles = batches.troubles
        self._geometries, self._hidden, self._marked = geometries, hidden, frozenset()

    def _show_pairs(self, pairs: ReportedPairs, options: ViewOptions) -> None:
        touching = pairs.distance < 0.0
        deep = pairs.rows(np.flatnonzero(touching))
        self._lines['distances'].show(pairs.rows(np.flatnonzero(~touching)).segments())
        self._lines['contacts'].show(deep.segments())
        normals = deep.normals(NORMAL_LENGTH) if options.normals else np.zeros((0, 2, 3))
        self._lines['normals'].show(normals)
        _set_points(self._points, deep.segments().reshape(-1, 3))

    def _show_selected(self, pair: ReportedPairs, options: ViewOptions) -> None:
        if not len(pair):
            self._lines['selected'].show(np.zeros((0, 2, 3)))
            self._selected_label.show('', None)
            return
        normal = pair.normals(NORMAL_LENGTH) if options.normals else np.zeros((0, 2, 3))
        self._lines['selected'].show(np.concatenate([pair.segments(), normal]))
        middle = pair.segments()[0].mean(axis=0)
        self._selected_label.show(in_words(pair, 0, bounds=options.bounds), middle)

    def _show_names(self, moment: ShownMoment, options: ViewOptions) -> None:
        geometries = moment.geometries
        if not options.names:
            for handle in self._names.values():
                handle.visible = False
            return
        for row, value in enumerate(geometries.ids[:MOST_NAMES].tolist()):
            position = moment.p_WGs[row]
            if value not in self._names:
                self._names[value] = self._scene.add_label(
                    f'/names/{value}', geometries.names[value], position=position
                )
            handle = self._names[value]
            handle.visible, handle.position = True, position

    def _show_frames(self, moment: ShownMoment, options: ViewOptions) -> None:
        if not options.frames:
            if self._axes is not None:
                self._axes.visible = False
            return
        wxyzs = np.roll(quaternions_from_rotations(moment.R_WFs), 1, axis=1)
        if self._axes is None or len(self._axes.batched_positions) != len(wxyzs):
            self._axes = self._scene.add_batched_axes(
                '/axes',
                wxyzs,
                moment.p_WFs,
                axes_length=_AXIS_LENGTH,
                axes_radius=_AXIS_RADIUS,
            )
        self._axes.visible = True
        self._axes.batched_wxyzs, self._axes.batched_positions = wxyzs, moment.p_WFs


class _ShownBatch:
    """A batch with the node that shows it."""

    def __init__(
        self, scene: Any, number: int, batch: SurfaceBatch, chosen: Callable[[int], None]
    ) -> None:
        self.batch = batch
        surface, count = batch.surface, len(batch.bodies)
        self.handle = scene.add_batched_meshes_simple(
            f'/{batch.layer}/{number}',
            vertices=surface.vertices,
            faces=surface.triangles,
            batched_wxyzs=np.tile([1.0, 0.0, 0.0, 0.0], (count, 1)),
            batched_positions=np.zeros((count, 3)),
            batched_scales=batch.scales,
            batched_colors=batch.colours,
            opacity=None if batch.alpha >= 1.0 else batch.alpha,
            flat_shading=not surface.smooth,
            # Transparent surfaces cost one drawing for each side.
            side='double' if surface.two_sided else 'front',
            lod='auto' if count > _MANY else 'off',
            cast_shadow=False,
            receive_shadow=False,
        )
        self.handle.on_click(partial(self._clicked, chosen))

    def pose(self, moment: ShownMoment) -> None:
        """Move the copies to the poses of their geometries."""
        # viser sends an array only if it differs from the one before.
        p_WSs, wxyzs = self.batch.posed(moment.R_WGs, moment.p_WGs)
        self.handle.batched_positions, self.handle.batched_wxyzs = p_WSs, wxyzs

    def mark(self, values: frozenset[int]) -> None:
        """Draw geometries, by id value, in the colour of what is selected."""
        colours = np.array(self.batch.colours)
        colours[np.isin(self.batch.geometries, list(values))] = _SELECTED
        self.handle.batched_colors = colours

    def _clicked(self, chosen: Callable[[int], None], event: Any) -> None:
        if event.instance_index is not None:
            chosen(int(self.batch.geometries[event.instance_index]))


class _Lines:
    """Lines of one colour."""

    def __init__(self, scene: Any, name: str, colour: tuple[int, ...], width: float) -> None:
        self._handle = scene.add_line_segments(
            f'/pairs/{name}',
            np.zeros((1, 2, 3)),
            colour,
            thickness=width,
            thickness_units='screen',
            visible=False,
        )

    def show(self, segments: Floats) -> None:
        """Draw segments (n, 2, 3) [m] instead of those before."""
        _set_points(self._handle, segments)


class _PressureSurfaces:
    """Contact surfaces, coloured by pressure."""

    def __init__(self, scene: Any) -> None:
        self._scene = scene
        self._handle: Any = None

    def show(self, patches: Patches) -> None:
        """Draw patches instead of those before."""
        if self._handle is not None:
            self._handle.remove()
            self._handle = None
        if len(patches):
            self._handle = self._scene.add_glb(
                '/contact_surfaces', _coloured(patches), cast_shadow=False, receive_shadow=False
            )


def _coloured(patches: Patches) -> bytes:
    """Return patches as glTF, with colours as a texture by pressure, exact within triangles."""
    from PIL import Image

    trimesh: Any = importlib.import_module('trimesh')  # half of it has no types

    shades = np.rint(255.0 * colours_of(np.linspace(0.0, 1.0, _SHADES), 1.0)).astype(np.uint8)
    # From the middle of the first texel to that of the last one.
    along = (0.5 + (_SHADES - 1) * patches.shares()) / _SHADES
    visual = trimesh.visual.TextureVisuals(
        uv=np.column_stack((along, np.full(len(along), 0.5))),
        material=trimesh.visual.material.PBRMaterial(
            baseColorTexture=Image.fromarray(shades[None]), doubleSided=True
        ),
    )
    mesh = trimesh.Trimesh(patches.vertices, patches.triangles, visual=visual, process=False)
    data: bytes = mesh.export(file_type='glb', tree_postprocessor=_make_unlit)
    return data


def _make_unlit(tree: Any) -> None:
    """Make the materials of a glTF tree independent of lights."""
    name = 'KHR_materials_unlit'
    tree['extensionsUsed'] = [name]
    for material in tree['materials']:
        material['extensions'] = {name: {}}


def _set_points(handle: Any, points: Floats) -> None:
    """Show points, or hide the node if there are none, since viser's nodes need one."""
    handle.visible = bool(len(points))
    if len(points):
        handle.points = points


class _Label:
    """A label that is visible while it has a position."""

    def __init__(self, scene: Any, name: str) -> None:
        self._handle = scene.add_label(name, '', font_screen_scale=_SMALL, visible=False)

    def show(self, text: str, p_W: Floats | None) -> None:
        self._handle.visible = p_W is not None
        if p_W is not None:
            self._handle.text = text
            self._handle.position = p_W
