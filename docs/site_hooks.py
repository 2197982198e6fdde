"""Hooks of mkdocs.yml: files of the repository that pages link to become part of the site.

A link such as ``../scenes/minimal.yaml`` works on a page of the repository, but leads out of the
site. Each such file is copied to ``source/`` as text, and the link is made to lead there.
"""

from __future__ import annotations

import re
from pathlib import Path
from posixpath import normpath, relpath
from typing import Any

from mkdocs.structure.files import File

# The target of a link that leads upwards, without its anchor.
_UPWARDS = re.compile(r'(?<=\]\()((?:\.\./)+[^)#]*)')


def on_files(files: Any, config: Any) -> Any:
    """Add every file outside the pages' folder that a page links to."""
    folder = Path(config['docs_dir'])
    for page in list(files.documentation_pages()):
        for target in _UPWARDS.findall(page.content_string):
            path = _outside(page, target)
            uri = f'source/{path}.txt'
            if path and files.get_file_from_path(uri) is None:
                text = (folder.parent / path).read_text(encoding='utf-8')
                files.append(File.generated(config, uri, content=text))
    return files


def on_page_markdown(markdown: str, page: Any, config: Any, files: Any) -> str:
    """Return the text of a page with its links upwards led to the copies."""

    def inside(match: re.Match[str]) -> str:
        path = _outside(page.file, match[1])
        here = page.file.src_uri.rpartition('/')[0] or '.'
        return relpath(f'source/{path}.txt', here) if path else match[1]

    return _UPWARDS.sub(inside, markdown)


def _outside(page: Any, target: str) -> str:
    """Return a link's path in the repository; empty where it stays among the pages."""
    path = normpath(f'docs/{page.src_uri}/../{target}')
    return '' if path.startswith('docs/') else path
