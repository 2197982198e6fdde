"""Viewer page in the browser, drawn with viser: ``serve`` shows a scene until interrupted."""
