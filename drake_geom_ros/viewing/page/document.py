"""The document of the page, with its style and scripts, around viser's picture in a frame."""

from __future__ import annotations

import functools
from pathlib import Path

_FOLDER = Path(__file__).parent / 'static'
_STYLES = ('page.css',)
_SCRIPTS = ('elements.js', 'link.js', 'pairs.js', 'panels.js', 'timeline.js', 'page.js')
PICTURE = '/3d/'  # the path of viser's page, followed by the key of the browser that shows it
SOCKET = '/link'  # the path of the web socket of the document


@functools.cache
def document() -> bytes:
    """Return the document, one file, so that no address in it depends on a token."""
    template = (_FOLDER / 'page.html').read_text(encoding='utf-8')
    style, script = (
        '\n'.join((_FOLDER / name).read_text(encoding='utf-8') for name in names)
        for names in (_STYLES, _SCRIPTS)
    )
    return template.replace('/* style */', style).replace('/* script */', script).encode()
