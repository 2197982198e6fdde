"""Windows that nobody sees."""

from __future__ import annotations

from typing import Any

from vtkmodules import vtkRenderingOpenGL2
from vtkmodules.vtkRenderingCore import vtkRenderWindow


def hidden_window() -> Any:
    """Return a window for images, by EGL where VTK has it: it takes neither X nor a screen."""
    kind = getattr(vtkRenderingOpenGL2, 'vtkEGLRenderWindow', vtkRenderWindow)
    window = kind()
    window.SetOffScreenRendering(1)
    # Samples in between would mix labels, and depths.
    window.SetMultiSamples(0)
    return window
