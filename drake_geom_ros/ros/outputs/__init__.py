"""What goes out by itself: results of cycles, markers, diagnostics, replay files."""
