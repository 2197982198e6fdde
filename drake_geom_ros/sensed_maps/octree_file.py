"""OctoMap's files: ``.bt`` (binary) and ``.ot`` (full), a header of text and a tree of bytes."""

from __future__ import annotations

import re

from drake_geom_ros.sensed_maps.cells import Cells, MapError, check_resolution
from drake_geom_ros.sensed_maps.octree import (
    binary_of_cells,
    cells_of_binary,
    cells_of_full,
    check_kind,
)

_FIRST_LINES = {
    '.bt': b'# Octomap OcTree binary file',
    '.ot': b'# Octomap OcTree file',
}
_LONGEST_HEADER = 10_000  # bytes
_DATA = re.compile(rb'^data[ \t]*\r?\n', re.MULTILINE)


def parse_octree_file(data: bytes, suffix: str) -> Cells:
    """Return the occupied cells of a file's content; ``suffix`` is ``.bt`` or ``.ot``.

    Raises MapError for content that is not whole, or none.
    """
    if not data.startswith(first := _FIRST_LINES[suffix]):
        raise MapError(f'it does not begin with {first.decode()!r}')
    found = _DATA.search(data, 0, _LONGEST_HEADER)
    if found is None:
        raise MapError("its header has no line 'data'")
    header = _header(data[: found.start()].decode(errors='replace'))
    if missing := [key for key in ('id', 'size', 'res') if key not in header]:
        raise MapError(f'its header lacks {", ".join(missing)}')
    check_kind(header['id'])
    try:
        resolution, size = float(header['res']), int(header['size'])
    except ValueError:
        told = f'res {header["res"][:80]!r}, size {header["size"][:80]!r}'
        raise MapError(f'its header says {told}, which are no numbers') from None
    check_resolution(resolution)
    tree = memoryview(data)[found.end() :]
    if size > 0 and not tree:
        raise MapError(f'its header tells of {size} nodes, and none follow: it is truncated')
    if suffix == '.bt':
        return cells_of_binary(tree, resolution)
    return cells_of_full(tree, resolution, header['id'])


def octree_file(cells: Cells) -> bytes:
    """Return the content of a ``.bt`` file; raises MapError for cells that no OctoMap holds."""
    tree = binary_of_cells(cells)
    header = (
        '# Octomap OcTree binary file\n'
        '# (feel free to add / change comments, but leave the first line as it is!)\n'
        f'#\nid OcTree\nsize {tree.nodes}\nres {cells.resolution!r}\ndata\n'
    )
    return header.encode() + tree.data


def _header(text: str) -> dict[str, str]:
    lines = (line.split(None, 1) for line in text.splitlines() if not line.startswith('#'))
    return {words[0]: words[1].strip() for words in lines if len(words) == 2}
