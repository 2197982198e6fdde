"""Lines about the live scene, kept until a node logs them."""

from __future__ import annotations

from dataclasses import dataclass, field


@dataclass
class SceneLog:
    """Notes, and warnings that are worth one line each."""

    notes: list[str] = field(default_factory=list)
    warnings: list[str] = field(default_factory=list)

    def take(self) -> tuple[list[str], list[str]]:
        """Return the notes and the warnings since the last call."""
        lines = self.notes, self.warnings
        self.notes, self.warnings = [], []
        return lines
