"""What is drawn by VTK, an extra: imported only by a renderer that was asked for."""
