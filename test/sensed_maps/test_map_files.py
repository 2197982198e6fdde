"""Files of maps: there and back, by other libraries, and what is refused at once."""

import struct
import tracemalloc

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

from drake_geom_ros.sensed_maps import MAP_SUFFIXES, Cells, MapError, MapFile, map_bytes, read_map
from drake_geom_ros.sensed_maps.pcd_file import parse_pcd, unpacked_lzf

POINTS = np.array([[0.1, -2.5, 3.25], [1e-3, 7.0, -0.5], [4.0, 4.0, 4.0]])
HEADER = (
    'VERSION .7\nFIELDS {fields}\nSIZE {sizes}\nTYPE {types}\nCOUNT {counts}\n'
    'WIDTH {count}\nHEIGHT 1\nPOINTS {count}\nDATA {data}\n'
)


def pcd(
    body, data='binary', fields='x y z', sizes='4 4 4', types='F F F', counts='1 1 1', count=3
):
    told = {'fields': fields, 'sizes': sizes, 'types': types, 'counts': counts}
    return HEADER.format(**told, count=count, data=data).encode() + body


@pytest.mark.parametrize('suffix', ['.pcd', '.ply', '.xyz', '.npy'])
def test_points_come_back_to_the_last_bit(tmp_path, suffix):
    path = tmp_path / f'a{suffix}'
    path.write_bytes(map_bytes(MapFile(POINTS), suffix))
    assert read_map(path).points.tobytes() == POINTS.tobytes()


def test_cells_come_back(tmp_path):
    cells = Cells.of_points(POINTS, 0.05)
    (tmp_path / 'a.bt').write_bytes(map_bytes(MapFile(POINTS), '.bt', 0.05))
    read = read_map(tmp_path / 'a.bt')
    assert read.cells.packed.tobytes() == cells.packed.tobytes()
    assert read.cells.resolution == 0.05
    assert read.points.tobytes() == cells.centres().tobytes()


def test_trimesh_reads_and_writes_the_same(tmp_path):
    for suffix in ('.ply', '.xyz'):
        (tmp_path / f'a{suffix}').write_bytes(map_bytes(MapFile(POINTS), suffix))
        assert np.array_equal(trimesh.load(tmp_path / f'a{suffix}').vertices, POINTS)
    # Before 5.0 trimesh writes no .xyz of points without colours.
    writes_xyz = int(trimesh.__version__.partition('.')[0]) >= 5
    for suffix in ('.ply', '.xyz') if writes_xyz else ('.ply',):
        trimesh.PointCloud(POINTS).export(tmp_path / f'b{suffix}')
        assert np.allclose(read_map(tmp_path / f'b{suffix}').points, POINTS, rtol=1e-6)


def test_numbers_that_are_not_finite_are_left_out_and_counted(tmp_path):
    np.save(tmp_path / 'a.npy', np.vstack([POINTS, [np.nan, 0, 0], [0, np.inf, 0]]))
    read = read_map(tmp_path / 'a.npy')
    assert read.left_out == 2
    assert np.array_equal(read.points, POINTS)


@pytest.mark.parametrize('data', ['ascii', 'binary', 'binary_compressed'])
def test_pcd_with_other_fields_between(data):
    rows = np.zeros(
        3, dtype=[('rgb', '<u4'), ('x', '<f4'), ('p', '<u1', 3), ('y', '<f8'), ('z', '<f4')]
    )
    for axis, column in zip('xyz', POINTS.T, strict=True):
        rows[axis] = column
    rows['rgb'], rows['p'] = 7, 9
    told = {
        'fields': 'rgb x _ y z',
        'sizes': '4 4 1 8 4',
        'types': 'U F U F F',
        'counts': '1 1 3 1 1',
    }
    if data == 'ascii':
        body = ''.join(
            f'7 {x} 9 9 9 {y} {z}\n'
            for x, y, z in zip(rows['x'], rows['y'], rows['z'], strict=True)
        ).encode()
    elif data == 'binary':
        body = rows.tobytes()
    else:
        plain = b''.join(rows[name].tobytes() for name in rows.dtype.names)
        packed = b''.join(
            bytes([len(plain[k : k + 32]) - 1]) + plain[k : k + 32]
            for k in range(0, len(plain), 32)
        )
        body = struct.pack('<2I', len(packed), len(plain)) + packed
    found = parse_pcd(pcd(body, data, **told))
    assert np.allclose(found, POINTS, rtol=1e-6)


def packed_lzf(data):
    """Return data as LZF packs it: the longest match of before, by looking everywhere."""
    out, plain, at = bytearray(), bytearray(), 0

    def flush():
        for k in range(0, len(plain), 32):
            out.extend(bytes([len(plain[k : k + 32]) - 1]) + plain[k : k + 32])
        plain.clear()

    while at < len(data):
        best, where = 0, 0
        for first in range(max(0, at - 8192), at):
            length = 0
            while (
                length < 264
                and at + length < len(data)
                and data[first + length] == data[at + length]
            ):
                length += 1
            if length > best:
                best, where = length, first
        if best < 3:
            plain.append(data[at])
            at += 1
            continue
        flush()
        back, told = at - where - 1, best - 2
        out.append(min(told, 7) << 5 | back >> 8)
        if told >= 7:
            out.append(told - 7)
        out.append(back & 255)
        at += best
    flush()
    return bytes(out)


@given(st.lists(st.sampled_from([b'a', b'ab', b'\0\0\0\0', b'xyz', b'\x81']), max_size=80))
@settings(max_examples=60, deadline=None)
def test_lzf_there_and_back(parts):
    data = b''.join(parts)
    assert unpacked_lzf(packed_lzf(data), len(data)) == data


@given(st.binary(max_size=200), st.integers(0, 500))
def test_damaged_lzf_is_refused_or_of_the_size_that_was_told(packed, size):
    try:
        found = unpacked_lzf(packed, size)
    except MapError:
        return
    assert len(found) == size


_NPY = b"\x93NUMPY\x01\x00v\x00{'descr': '%s', 'fortran_order': False, 'shape': (%d, 3), }"
_PLY = b'ply\nformat %s 1.0\nelement vertex 99999999999\nproperty float x\nproperty float y\n'
_BT = b'# Octomap OcTree binary file\n'
_MANY = f'1 1 1 {10**15}'
_OTHER = 'x y z q', '4 4 4 4', 'F F F F', '1 1 1 1'


def npy(kind, rows):
    return (_NPY % (kind, rows)).ljust(127) + b'\n'


def bt(id=b'OcTree', size=b'5', res=b'0.1', tree=b'\x02\x00'):
    return _BT + b'id %s\nsize %s\nres %s\ndata\n%s' % (id, size, res, tree)


def tree(suffix, size=17):
    """Return a file of a tree of 17 nodes, one of them a leaf."""
    if suffix == '.bt':
        nodes = struct.pack('<16H', *[3] * 15, 2)
        return bt(size=b'%d' % size, tree=nodes)
    nodes = struct.pack('<fB', 1.0, 1) * 16 + struct.pack('<fB', 1.0, 0)
    return bt(size=b'%d' % size, tree=nodes).replace(b' binary', b'')


PLY = map_bytes(MapFile(POINTS), '.ply')


def compressed(points=POINTS):
    """Return points as float32 in LZF that packs nothing, with both sizes before."""
    plain = np.ascontiguousarray(points.T, '<f4').tobytes()
    packed = b''.join(
        bytes([len(plain[k : k + 32]) - 1]) + plain[k : k + 32] for k in range(0, len(plain), 32)
    )
    return struct.pack('<2I', len(packed), len(plain)) + packed


def filling_a_page(body, more=0, page=4096, data='binary_compressed'):
    """Return a file as older versions of PCL left it: zeros up to a page more than its data."""
    header = pcd(b'', data)
    return header + body + bytes(page - len(header) + more)


def seen_from(viewpoint):
    return pcd(POINTS.astype('<f4').tobytes()).replace(
        b'POINTS', b'VIEWPOINT %s\nPOINTS' % viewpoint.encode()
    )


LIES = [
    ('.pcd', pcd(POINTS.astype('<f4').tobytes()[:-1]), 'truncated'),
    ('.pcd', pcd(b'', count=10**15), 'at most'),
    ('.pcd', pcd(b'', counts='1 1 9'), 'must be one number'),
    ('.pcd', pcd(b'', counts=f'1 1 {10**15}'), 'at most'),
    ('.pcd', pcd(b'', 'binary', 'x y z q', '4 4 4 8', 'F F F F', _MANY), 'at most'),
    ('.pcd', pcd(b'', data='ascii'), 'and none follow'),
    ('.pcd', pcd(b'1 2 q\n' * 3, data='ascii'), 'cannot be read'),
    ('.pcd', pcd(b'', data='zip'), "'zip'"),
    ('.pcd', pcd(b'', types='F F U'), 'must be one number'),
    ('.pcd', pcd(b'', fields='x y q'), 'must have x, y and z'),
    ('.pcd', pcd(struct.pack('<2I', 4, 2**31), 'binary_compressed'), 'unpacks to'),
    ('.pcd', pcd(struct.pack('<2I', 2**31, 36), 'binary_compressed'), 'truncated'),
    ('.pcd', pcd(POINTS.astype('<f4').tobytes() + b'\0' * 12), '48 bytes of data follow'),
    ('.pcd', pcd(compressed() + b'\0', 'binary_compressed'), '47 bytes of data follow'),
    ('.pcd', filling_a_page(compressed()[:-1] + b'\1', -1), '4[0-9]+ bytes of data follow'),
    ('.pcd', pcd(b'1 2 3\n1 2 3 4\n1 2 3\n', data='ascii'), '3 numbers, and its row 2 has 4'),
    ('.pcd', pcd(b'1 2 3\n1 2 3\n1 2\n', data='ascii'), '3 numbers, and its row 3 has 2'),
    ('.pcd', pcd(b'').replace(b'HEIGHT 1', b'POINTS 3'), "'POINTS' twice"),
    *(
        ('.pcd', seen_from(viewpoint), r"VIEWPOINT is .*; it must be '0 0 0 1 0 0 0'")
        for viewpoint in ('1 0 0 1 0 0 0', '0 0 0 0 1 0 0', '0 0 0', 'nan 0 0 1 0 0 0', 'there')
    ),
    ('.ply', PLY.replace(b'property', b'property double x\nproperty', 1), "'x' twice"),
    ('.ply', PLY + PLY.replace(b'ply', b'', 1), 'left over'),
    ('.pcd', pcd(b'1 2 3\n' * 2, data='ascii'), 'tells of 3 points, and 2 follow'),
    ('.pcd', pcd(b'1 2 3\n' * 4, data='ascii'), 'tells of 3 points, and more follow'),
    ('.pcd', pcd(b'1 2 3\n', data='ascii', count=0), 'tells of 0 points, and more follow'),
    ('.pcd', pcd(b'1 2 3 4\n' * 3, data='ascii'), '3 numbers, and its row 1 has 4'),
    ('.pcd', pcd(b'1 2 3 4\n1 2 3\n1 2 3 4', 'ascii', *_OTHER), 'cannot be read'),
    ('.pcd', b'DATA binary\n', 'lacks FIELDS'),
    ('.pcd', b'x' * 100_000, 'no header'),
    ('.ply', _PLY % b'binary_little_endian' + b'property float z\nend_header\n', 'truncated'),
    ('.ply', _PLY % b'ascii' + b'property float z\nend_header\n1 2 3\n', 'truncated'),
    ('.ply', b'not a ply', 'does not begin'),
    ('.xyz', b'1 2\n', 'three numbers'),
    ('.xyz', b'one two three\n', 'three numbers'),
    ('.npy', b'\x93NUMPY\x01\x00', 'no header'),
    ('.npy', npy(b'<f8', 99999999999), 'truncated'),
    ('.npy', npy(b'|O', 3), 'of floats'),
    ('.npy', npy(b'<f8', -1) + bytes(24), 'must be'),
    ('.npy', npy(b'<f8', -2) + bytes(40), 'must be'),
    ('.npy', npy(b'<f8', 1) + bytes(48), '24 bytes follow its array'),
    ('.npy', npy(b'<f8', 1).replace(b'(1, 3)', b'(3,)  ') + bytes(24), 'must be'),
    ('.npy', npy(b'<f8', 1).replace(b'(1, 3)', b'()    ') + bytes(8), 'must be'),
    ('.npy', npy(b'<f8', 3).replace(b'(3, 3)', b'(3, 2)') + bytes(48), 'must be'),
    ('.npy', npy(b'<c8', 1) + bytes(24), 'of floats'),
    ('.bt', bt(tree=b''), 'truncated'),
    ('.bt', bt(res=b'1e9'), 'must lie in'),
    *(('.bt', bt(res=res), 'they must be') for res in (b'nan', b'1_0', b'-1', b'0x1', b'1 2')),
    *(('.bt', bt(size=size), 'whole number') for size in (b'x', b'-5', b'5.0', b'1_0', b'9' * 19)),
    *(
        (suffix, tree(suffix, size), 'tells of [0-9]+ nodes, and 17 follow')
        for suffix in ('.bt', '.ot')
        for size in (0, 16, 18, 500000)
    ),
    ('.bt', bt(res=b'0.1\nres 0.2'), "'res' twice"),
    ('.bt', bt(), 'at most'),
    ('.bt', bt(id=b'Tree'), "'Tree'"),
    ('.bt', _BT + b'size 5\nres 0.1\ndata\n', 'lacks id'),
    ('.bt', _BT + b'#' * 20_000, "no line 'data'"),
    ('.ot', _BT, 'does not begin'),
    ('.bt', b'', 'empty'),
    ('.stl', b'solid', "'.stl'"),
]


@pytest.mark.parametrize(('suffix', 'data', 'reason'), LIES)
def test_what_lies_is_refused_with_its_name_and_no_memory_is_taken(tmp_path, suffix, data, reason):
    path = tmp_path / f'hostile{suffix}'
    path.write_bytes(data)
    tracemalloc.start()
    try:
        with pytest.raises(MapError, match=reason) as caught:
            read_map(path)
        assert tracemalloc.get_traced_memory()[1] < 20e6
    finally:
        tracemalloc.stop()
    assert f'hostile{suffix}' in str(caught.value)


@pytest.mark.parametrize('suffix', ['.bt', '.ot'])
def test_a_header_that_counts_its_nodes_is_right(tmp_path, suffix):
    (tmp_path / f'a{suffix}').write_bytes(tree(suffix))
    assert len(read_map(tmp_path / f'a{suffix}').cells) == 1


@pytest.mark.parametrize('suffix', MAP_SUFFIXES)
@given(data=st.binary(max_size=400), whole=st.booleans(), cut=st.integers(0, 400))
@settings(max_examples=60, deadline=None)
def test_garbage_and_cut_files_raise_nothing_but_map_errors(
    tmp_path_factory, suffix, data, whole, cut
):
    if suffix != '.ot' and whole:
        data = map_bytes(MapFile(POINTS), suffix, 0.05)[:cut]
    path = tmp_path_factory.mktemp('garbage') / f'a{suffix}'
    path.write_bytes(data)
    try:
        found = read_map(path)
    except MapError:
        return
    assert np.isfinite(found.points).all()


def test_what_is_no_file_is_refused(tmp_path):
    with pytest.raises(MapError, match='No such file'):
        read_map(tmp_path / 'none.pcd')
    (tmp_path / 'folder.pcd').mkdir()
    with pytest.raises(MapError, match='cannot be read'):
        read_map(tmp_path / 'folder.pcd')


def test_points_without_a_resolution_are_no_cells():
    with pytest.raises(MapError, match='was not given'):
        map_bytes(MapFile(POINTS), '.bt')
    with pytest.raises(MapError, match=r"as '\.ot'"):
        map_bytes(MapFile(POINTS), '.ot')


@pytest.mark.parametrize(
    ('name', 'data'),
    [
        ('a.pcd', pcd(b'', count=0)),
        ('a.pcd', pcd(b'', data='ascii', count=0)),
        ('a.npy', npy(b'<f8', 0)),
        ('a.pcd', pcd(POINTS.astype('<f4').tobytes() + b'\n')),
        ('a.pcd', pcd(b'1 2 3\r\n' * 3 + b'\n\n', data='ascii')),
        ('a.pcd', pcd(b'1 2 3\n\n1 2 3\n1 2 3\n', data='ascii')),
        ('a.pcd', seen_from('0 0 -0.0 -1 0 0 0')),
        *(
            ('a.pcd', filling_a_page(body, page=page, data=data))
            for page in (4096, 16384, 65536)
            for data, body in (
                ('binary', POINTS.astype('<f4').tobytes()),
                ('binary_compressed', compressed()),
            )
        ),
    ],
)
def test_a_file_of_nothing_and_one_with_what_its_writer_leaves_at_the_end_are_whole(
    tmp_path, name, data
):
    (tmp_path / name).write_bytes(data)
    found = read_map(tmp_path / name).points
    assert found.shape in ((0, 3), (3, 3))
