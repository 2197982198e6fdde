"""PCL's point cloud files, ``.pcd``: ascii, binary, and binary_compressed.

Source: the Point Cloud Library's documentation of its file format, version 0.7; LZF is Marc
Lehmann's LibLZF.
"""

from __future__ import annotations

import io
from collections.abc import Iterator

import numpy as np

from drake_geom_ros.math.array_types import Floats
from drake_geom_ros.sensed_maps.cells import MapError

MOST_POINTS = 20_000_000  # of a file
_LONGEST_HEADER = 10_000  # bytes
_MOST_NUMBERS = 10_000  # of a field in a row
_KINDS = {'F': {4, 8}, 'I': {1, 2, 4, 8}, 'U': {1, 2, 4, 8}}
_LISTS = ('FIELDS', 'SIZE', 'TYPE')
_PAGES = (4096, 16384, 65536)  # bytes of memory


def parse_pcd(data: bytes) -> Floats:
    """Return the points (n, 3) in a file's content, in its order; some may not be finite.

    Raises MapError for incomplete or invalid content.
    """
    header, kind, start = _header(data)
    row, count = _row(header), _count(header)
    _refuse_viewpoint(header.get('VIEWPOINT'))
    body = memoryview(data)[start:]
    if kind == 'ascii':
        return _ascii(body, row, count)
    if kind == 'binary_compressed':
        # It is laid out field by field: all x, then all y.
        table = _decompressed(body, row.itemsize * count, start)
        offsets = [row.fields[axis][1] * count for axis in 'xyz'] if row.fields else []
        kinds = [row[axis].base for axis in 'xyz']
        columns = [
            np.frombuffer(table, of, count, offset)
            for of, offset in zip(kinds, offsets, strict=True)
        ]
        return np.stack([column.astype(np.float64) for column in columns], axis=1)
    _refuse_other_size(body, row.itemsize * count, start)
    rows = np.frombuffer(body, row, count)
    return np.stack([rows[axis].astype(np.float64) for axis in 'xyz'], axis=1)


def pcd_file(points: Floats) -> bytes:
    """Return the content of a binary ``.pcd`` of points (n, 3), as float64."""
    count = len(points)
    header = (
        '# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS x y z\nSIZE 8 8 8\n'
        f'TYPE F F F\nCOUNT 1 1 1\nWIDTH {count}\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\n'
        f'POINTS {count}\nDATA binary\n'
    )
    return header.encode() + points.astype('<f8').tobytes()


def _header(data: bytes) -> tuple[dict[str, list[str]], str, int]:
    """Return the header by its keys, the kind of data, and the offset of the data."""
    header: dict[str, list[str]] = {}
    start = 0
    while (end := data.find(b'\n', start, _LONGEST_HEADER)) >= 0:
        words = data[start:end].decode(errors='replace').split()
        start = end + 1
        if not words or words[0].startswith('#'):
            continue
        if words[0] in header:
            raise MapError(f'its header has {words[0][:80]!r} twice; it must be there once')
        header[words[0]] = words[1:]
        if words[0] == 'DATA':
            kind = ' '.join(words[1:])
            if kind not in ('ascii', 'binary', 'binary_compressed'):
                raise MapError(
                    f'its data are {kind[:80]!r}; ascii, binary, binary_compressed are read'
                )
            return header, kind, start
    raise MapError("it has no header of a PCD file, which ends with the line 'DATA'")


def _row(header: dict[str, list[str]]) -> np.dtype[np.void]:
    """Return the type of a row: a record of all fields."""
    if missing := [key for key in _LISTS if key not in header]:
        raise MapError(f'its header lacks {", ".join(missing)}')
    names, sizes, kinds = (header[key] for key in _LISTS)
    counts = header.get('COUNT', ['1'] * len(names))
    if not len(names) == len(sizes) == len(kinds) == len(counts):
        raise MapError('FIELDS, SIZE, TYPE and COUNT of its header differ in length')
    if missing := [axis for axis in 'xyz' if names.count(axis) != 1]:
        raise MapError(f'its fields are {" ".join(names)[:200]}; it must have x, y and z, once')
    fields = []
    for k, (name, size, kind, count) in enumerate(zip(names, sizes, kinds, counts, strict=True)):
        width, many = _whole(size, 'SIZE'), _whole(count, 'COUNT')
        if many > _MOST_NUMBERS:
            raise MapError(f'field {name!r} has COUNT {many}; at most {_MOST_NUMBERS} are read')
        if width not in _KINDS.get(kind, ()):
            raise MapError(f'field {name!r} is of TYPE {kind!r} and SIZE {size!r}, which is none')
        if name in ('x', 'y', 'z') and (kind != 'F' or many != 1):
            raise MapError(f'field {name} must be one number of TYPE F')
        # Padding is called '_', any number of times.
        field = name if name in ('x', 'y', 'z') else str(k)
        fields.append((field, f'<{kind.lower()}{width}', (many,) if many != 1 else ()))
    return np.dtype(fields)


def _count(header: dict[str, list[str]]) -> int:
    """Return the number of points by the header."""
    sizes = {
        key: _whole(header[key][0], key)
        for key in ('WIDTH', 'HEIGHT', 'POINTS')
        if header.get(key)
    }
    if 'POINTS' not in sizes and not {'WIDTH', 'HEIGHT'} <= sizes.keys():
        raise MapError('its header lacks POINTS')
    organised = sizes.get('WIDTH', 0) * sizes.get('HEIGHT', 1)
    count = sizes.get('POINTS', organised)
    if 'WIDTH' in sizes and organised != count:
        raise MapError(f'its header tells of {count} points, and of {organised} by its rows')
    if count > MOST_POINTS:
        raise MapError(f'its header tells of {count} points; at most {MOST_POINTS} are read')
    return count


def _whole(word: str, key: str) -> int:
    if not word.isascii() or not word.isdigit() or len(word) > 18:
        raise MapError(f'{key} of its header holds {word[:80]!r}; it must be a whole number')
    return int(word)


def _refuse_viewpoint(words: list[str] | None) -> None:
    """Raise MapError for a sensor's pose other than the identity.

    PCL's documentation leaves open whether points are in the sensor's frame or were already moved
    by it. There are writers of both kinds (CloudCompare stores its pending transformation there),
    and readers too.
    """
    if words is None:
        return
    try:
        numbers = [float(word) for word in words]
    except ValueError:
        numbers = []
    if numbers[:3] != [0.0] * 3 or [abs(x) for x in numbers[3:]] != [1.0, 0.0, 0.0, 0.0]:
        raise MapError(
            f"its VIEWPOINT is {' '.join(words)[:200]!r}; it must be '0 0 0 1 0 0 0', for the "
            'format leaves open whether the points were moved by it already: move them where they '
            'are, and write that'
        )


def _refuse_other_size(body: memoryview, needed: int, start: int) -> None:
    """Raise MapError for data of fewer bytes than needed, or more.

    A final newline is ignored, and so is the padding of older versions of PCL, which made a file
    longer than its data by a page for the header.
    """
    if len(body) < needed:
        raise MapError(f'it is truncated: {len(body)} bytes of data of {needed}')
    rest = bytes(body[needed:]) if len(body) - needed <= max(_PAGES) else None
    fills_page = rest is not None and len(rest) + start in _PAGES and not any(rest)
    if rest not in (b'', b'\n') and not fills_page:
        raise MapError(f'{len(body)} bytes of data follow its header, which tells of {needed}')


def _ascii(body: memoryview, row: np.dtype[np.void], count: int) -> Floats:
    names = row.names or ()
    before = np.cumsum([0, *(int(np.prod(row[name].shape)) for name in names)]).tolist()
    columns = [before[names.index(axis)] for axis in 'xyz']
    text = bytes(body).strip()
    if not text:
        if count:
            raise MapError(f'its header tells of {count} points, and none follow')
        return np.zeros((0, 3))
    try:
        points = np.loadtxt(
            _rows_of(text, before[-1]), usecols=columns, max_rows=count + 1, ndmin=2, comments=None
        )
    except MapError:
        raise
    except ValueError as error:
        raise MapError(f'its points cannot be read: {error}') from None
    if len(points) != count:
        many = 'more' if len(points) > count else str(len(points))
        raise MapError(f'its header tells of {count} points, and {many} follow')
    return np.ascontiguousarray(points)


def _rows_of(text: bytes, width: int) -> Iterator[bytes]:
    """Yield the lines of a text without empty ones; MapError unless each has ``width`` words."""
    for number, line in enumerate(io.BytesIO(text), 1):
        words = len(line.split())
        if not words:
            continue
        if words != width:
            raise MapError(f'its fields have {width} numbers, and its row {number} has {words}')
        yield line


def _decompressed(body: memoryview, expected: int, start: int) -> bytes:
    """Return the decompressed data of a body: two sizes of 4 bytes, then LZF data."""
    if len(body) < 8:
        raise MapError(f'it is truncated: {len(body)} bytes of data of 8')
    packed, unpacked = np.frombuffer(body, '<u4', 2).tolist()
    if unpacked != expected:
        raise MapError(
            f'it unpacks to {unpacked} bytes, and its header tells of {expected} of points'
        )
    _refuse_other_size(body, 8 + packed, start)
    return unpacked_lzf(bytes(body[8 : 8 + packed]), unpacked)


def unpacked_lzf(packed: bytes, size: int) -> bytes:
    """Return the ``size`` bytes of LZF data; raises MapError for damaged data."""
    out = bytearray()
    at, end = 0, len(packed)
    try:
        while at < end and len(out) <= size:
            control = packed[at]
            at += 1
            if control < 32:  # a literal run of control + 1 bytes
                if at + control >= end:
                    raise IndexError
                out += packed[at : at + control + 1]
                at += control + 1
                continue
            length = control >> 5  # a back reference to earlier bytes
            if length == 7:
                length += packed[at]
                at += 1
            first = len(out) - ((control & 31) << 8) - packed[at] - 1
            at += 1
            if first < 0:
                raise IndexError
            again = out[first : first + length + 2]
            while len(again) < length + 2:  # the reference overlaps its own output
                again += again[: length + 2 - len(again)]
            out += again
    except IndexError:
        raise MapError('its compressed data are damaged') from None
    if len(out) != size:
        raise MapError(f'its compressed data hold {len(out)} bytes of {size}')
    return bytes(out)
