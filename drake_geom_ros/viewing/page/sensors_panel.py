"""Panel of sensed maps: a checkbox for each source and each kind of layer, hidden without maps."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from html import escape
from typing import Any

from drake_geom_ros.viewing.cell_layers import CELL_LAYERS, CellLayer


class SensorsPanel:
    """Panel that chooses layers of sensed maps and says how many cells each source shows."""

    def __init__(self, gui: Any, touch: Callable[[], None]) -> None:
        """Add the controls to ``gui``; ``touch()`` is called when a choice changes."""
        self._gui, self._touch = gui, touch
        self._folder = gui.add_folder('Sensors', visible=False)
        with self._folder:
            self.kinds = {kind: self._checkbox(label) for kind, label in CELL_LAYERS.items()}
            self.lines = gui.add_html('')
        self.sources: dict[str, Any] = {}  # checkboxes by source

    def chosen(self, layers: Sequence[CellLayer]) -> list[CellLayer]:
        """Return the layers to draw; a source that is new is drawn."""
        return [
            layer
            for layer in layers
            if self.kinds[layer.kind].value
            and (layer.source not in self.sources or self.sources[layer.source].value)
        ]

    def show(self, layers: Sequence[CellLayer]) -> None:
        """Show which sources there are, and how many cells of each kind."""
        self._folder.visible = bool(layers)
        sources = sorted({layer.source for layer in layers})
        for source in [name for name in self.sources if name not in sources]:
            self.sources.pop(source).remove()
        with self._folder:
            for source in sources:
                if source not in self.sources:
                    self.sources[source] = self._checkbox(source)
        rows = sorted(layers, key=lambda layer: layer.key)
        self.lines.content = ''.join(map(_line, rows))

    def _checkbox(self, label: str) -> Any:
        box = self._gui.add_checkbox(label, True)
        box.on_update(lambda _: self._touch())
        return box


def _line(layer: CellLayer) -> str:
    red, green, blue = (round(255.0 * part) for part in layer.colour[:3])
    square = f'<span style="color:rgb({red},{green},{blue})">&#9632;</span>'
    text = f'{layer.source}: {len(layer.centres)} {CELL_LAYERS[layer.kind]}'
    return f'<div style="padding:0 1em">{square} {escape(text)}</div>'
