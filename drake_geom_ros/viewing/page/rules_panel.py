"""Panel of proximity rules with their states, hidden if there are none."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape
from typing import Any

from drake_geom_ros.viewing.rules import COLOURS, ShownRule


class RulesPanel:
    """Panel with a line for each rule, in the colour of its level while it is entered."""

    def __init__(self, gui: Any) -> None:
        self._folder = gui.add_folder('Proximity rules', visible=False)
        with self._folder:
            self.lines = gui.add_html('')

    def show(self, rules: Sequence[ShownRule]) -> None:
        """Show the states of rules, entered ones first."""
        self._folder.visible = bool(rules)
        entered_first = sorted(rules, key=lambda rule: not rule.is_entered)
        content = ''.join(map(_line, entered_first))
        self.lines.content = f'<div style="padding:0 1em">{content}</div>'


def _line(rule: ShownRule) -> str:
    colour = 'rgb({}, {}, {})'.format(*COLOURS[rule.level]) if rule.is_entered else 'inherit'
    return f'<div style="color:{colour}">{escape(rule.in_words())}</div>'
