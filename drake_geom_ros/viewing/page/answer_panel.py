"""Panel with display options, query options and the table of nearest pairs."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from html import escape
from typing import Any

from drake_geom_ros.geometry import ACCURACY_LEVELS, accuracy_of
from drake_geom_ros.viewing.looks import LAYERS
from drake_geom_ros.viewing.page.picture import DisplayOptions
from drake_geom_ros.viewing.shown_pairs import in_words, row_in_words
from drake_geom_ros.viewing.shown_scene import ShownMoment

_ROWS = 12
_FARTHEST, _STEP = 2.0, 0.01  # [m] of the slider
# mantine-Button-* are the public names by which Mantine, which draws viser's panels, is styled.
_TABLE = """<div class="pairs"></div><style>
div:has(> .pairs) ~ div .mantine-Button-root {padding: 0 0.3rem}
div:has(> .pairs) ~ div .mantine-Button-label {font-size: 0.75rem}</style>"""
LEVELS: tuple[str, ...] = tuple(ACCURACY_LEVELS)


class AnswerPanel:
    """Panel of display and query options, with the nearest pairs to select from."""

    def __init__(
        self,
        gui: Any,
        touch: Callable[[], None],
        select: Callable[[tuple[int, int]], None],
        max_distance: float,
        accuracy: str,
        *,
        contacts: bool = False,
    ) -> None:
        """Add the controls to ``gui``.

        ``touch()`` is called when the picture is outdated, ``select(pair)`` with the id values of
        a chosen pair.
        """
        self._select = select
        # A length has a mark between the levels around it.
        self._levels = sorted({*LEVELS, accuracy_of(accuracy)}, key=_length, reverse=True)
        self._ids: list[tuple[int, int]] = []
        with gui.add_folder('Show'):
            self._layers = {
                name: gui.add_checkbox(name, name == 'proximity') for name in LAYERS.values()
            }
            self._names = gui.add_checkbox('names', False)
            self._frames = gui.add_checkbox('frames', False)
            self._normals = gui.add_checkbox('normals', True)
            self._bounds = gui.add_checkbox('error bounds', False)
            self.contacts = gui.add_checkbox('contact surfaces', contacts)
        with gui.add_folder('Answer'):
            farthest = max(_FARTHEST, max_distance)
            self.max_distance = gui.add_slider(
                'max_distance [m]', 0.0, farthest, _STEP, max_distance
            )
            self.level = gui.add_slider(
                'accuracy',
                min=0,
                max=len(self._levels) - 1,
                step=1,
                initial_value=self._levels.index(accuracy),
                marks=tuple(enumerate(self._levels)),
            )
            gui.add_html(_TABLE)
            self.rows = [gui.add_button('', visible=False) for _ in range(_ROWS)]
            self.details = gui.add_html('')
        for row, button in enumerate(self.rows):
            button.on_click(partial(self._clicked, row))
        for handle in (
            *self._layers.values(),
            self._names,
            self._frames,
            self._normals,
            self._bounds,
            self.contacts,
            self.max_distance,
            self.level,
        ):
            handle.on_update(lambda _: touch())

    def display_options(self) -> DisplayOptions:
        """Return the current display options."""
        return DisplayOptions(
            layers=frozenset(name for name, box in self._layers.items() if box.value),
            names=self._names.value,
            frames=self._frames.value,
            normals=self._normals.value,
            bounds=self._bounds.value,
        )

    @property
    def accuracy(self) -> str:
        """The selected accuracy, as text."""
        return self._levels[int(self.level.value)]

    def show(self, moment: ShownMoment, selected: tuple[int, int] | None) -> None:
        """Fill the table: the nearest pairs first, the chosen one marked."""
        pairs = moment.pairs.rows(slice(_ROWS))
        self._ids = [(a, b) for a, b in pairs.ids.tolist()]
        for row, button in enumerate(self.rows):
            has_pair = row < len(pairs)
            if has_pair:
                bounds, short = self._bounds.value, moment.geometries.short_names
                button.label = row_in_words(pairs, row, short, bounds=bounds)
                marked = self._ids[row] == selected
                button.color = 'violet' if marked else _colour(float(pairs.distance[row]))
            button.visible = has_pair
        self.details.content = '' if selected is None else self._in_full(moment, selected)

    def _in_full(self, moment: ShownMoment, pair: tuple[int, int]) -> str:
        """Return the names of a pair, and its distance if the pair is shown."""
        names, row = moment.geometries.names, moment.pairs.find(pair)
        lines = [names.get(value, '') for value in pair]
        if row is not None:
            lines.append(in_words(moment.pairs, row, bounds=self._bounds.value))
        shown = ''.join(f'<div>{escape(line)}</div>' for line in lines)
        return f'<div style="padding:0 1em">{shown}</div>'

    def _clicked(self, row: int, event: Any) -> None:
        if row < len(self._ids):
            self._select(self._ids[row])


def _colour(distance: float) -> str:
    return 'red' if distance < 0.0 else 'gray'


def _length(accuracy: str) -> float:
    """Return the largest error [m] of an accuracy."""
    return accuracy_of(accuracy).length
