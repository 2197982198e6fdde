"""Invisible windows for rendering."""

from __future__ import annotations

from typing import Any

from vtkmodules import vtkRenderingOpenGL2
from vtkmodules.vtkRenderingCore import vtkRenderWindow


def hidden_window() -> Any:
    """Return a window for images, by EGL if VTK has it, which needs neither X nor a screen."""
    kind = getattr(vtkRenderingOpenGL2, 'vtkEGLRenderWindow', vtkRenderWindow)
    window = kind()
    window.SetOffScreenRendering(1)
    # Multisampling would mix labels, and depths.
    window.SetMultiSamples(0)
    return window
