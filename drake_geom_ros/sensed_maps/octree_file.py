"""OctoMap files: ``.bt`` (binary) and ``.ot`` (full), a text header and a tree of bytes."""

from __future__ import annotations

import re

from drake_geom_ros.sensed_maps.cells import Cells, MapError, check_resolution
from drake_geom_ros.sensed_maps.octree import (
    binary_of_cells,
    cells_of_binary,
    cells_of_full,
    check_kind,
    count_nodes,
)

_FIRST_LINES = {
    '.bt': b'# Octomap OcTree binary file',
    '.ot': b'# Octomap OcTree file',
}
_LONGEST_HEADER = 10_000  # bytes
# float() and int() accept more: underscores, other digits, nan.
_NUMBER = re.compile(r'(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?', re.ASCII)
_WHOLE = re.compile(r'\d{1,18}', re.ASCII)
_DATA = re.compile(rb'^data[ \t]*\r?\n', re.MULTILINE)


def parse_octree_file(data: bytes, suffix: str) -> Cells:
    """Return the occupied cells of a file's content; ``suffix`` is ``.bt`` or ``.ot``.

    Raises MapError for incomplete or invalid content.
    """
    if not data.startswith(first := _FIRST_LINES[suffix]):
        raise MapError(f'it does not begin with {first.decode()!r}')
    data_line = _DATA.search(data, 0, _LONGEST_HEADER)
    if data_line is None:
        raise MapError("its header has no line 'data'")
    header = _header(data[: data_line.start()].decode(errors='replace'))
    if missing := [key for key in ('id', 'size', 'res') if key not in header]:
        raise MapError(f'its header lacks {", ".join(missing)}')
    check_kind(header['id'])
    resolution, size = _numbers(header['res'], header['size'])
    check_resolution(resolution)
    tree = memoryview(data)[data_line.end() :]
    if size > 0 and not tree:
        raise MapError(f'its header tells of {size} nodes, and none follow: it is truncated')
    is_binary = suffix == '.bt'
    cells = (
        cells_of_binary(tree, resolution)
        if is_binary
        else cells_of_full(tree, resolution, header['id'])
    )
    if (nodes := count_nodes(tree, header['id'], binary=is_binary)) != size:
        raise MapError(f'its header tells of {size} nodes, and {nodes} follow')
    return cells


def octree_file(cells: Cells) -> bytes:
    """Return the content of a ``.bt`` file; raises MapError for cells beyond OctoMap's range."""
    tree = binary_of_cells(cells)
    header = (
        '# Octomap OcTree binary file\n'
        '# (feel free to add / change comments, but leave the first line as it is!)\n'
        f'#\nid OcTree\nsize {tree.nodes}\nres {cells.resolution!r}\ndata\n'
    )
    return header.encode() + tree.data


def _header(text: str) -> dict[str, str]:
    header: dict[str, str] = {}
    for line in text.splitlines():
        words = line.split(None, 1)
        if line.startswith('#') or len(words) != 2:
            continue
        if words[0] in header:
            raise MapError(f'its header has {words[0][:80]!r} twice; it must be there once')
        header[words[0]] = words[1].strip()
    return header


def _numbers(res: str, size: str) -> tuple[float, int]:
    """Return the resolution [m] and the number of nodes from texts of a header."""
    if not _NUMBER.fullmatch(res) or not _WHOLE.fullmatch(size):
        raise MapError(
            f'its header says res {res[:80]!r}, size {size[:80]!r}; they must be a number [m] and '
            'a whole number of nodes'
        )
    return float(res), int(size)
