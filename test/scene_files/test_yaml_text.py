import math

import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st

from drake_geom_ros.scene_files import yaml_text
from drake_geom_ros.scene_files.errors import SceneFileError
from drake_geom_ros.scene_files.yaml_text import key_text, read_yaml


def fault(text):
    with pytest.raises(SceneFileError) as caught:
        read_yaml(text, 'a.yaml')
    assert str(caught.value).startswith('a.yaml')
    return caught.value


def test_each_value_has_its_line_and_key():
    text = '# head\na:\n  - 1\n  - b: [x,\n      y]\n    c: "q"\n'
    document = read_yaml(text, 'a.yaml')
    assert document.value == {'a': [1, {'b': ['x', 'y'], 'c': 'q'}]}
    place = document.at('a', 1, 'b', 1)
    assert (place.line, place.key) == (5, 'a[1].b[1]')
    assert document.at('a', 1, 'c').line == 6


def test_an_entry_of_a_mapping_is_placed_at_its_key():
    document = read_yaml('a:\n  b:\n    c: 1\n  d:\n    - 2\n', 'a.yaml')
    assert [document.at(*path).line for path in (('a',), ('a', 'b'), ('a', 'd'))] == [1, 2, 4]
    assert document.at('a', 'd', 0).line == 5


def test_a_missing_part_is_placed_at_its_nearest_parent():
    document = read_yaml('a:\n\n  b: 1\n', 'a.yaml')
    place = document.at('a', 'x', 0)
    assert (place.line, place.key) == (1, 'a.x[0]')


def test_key_text():
    assert key_text(('geometries', 3, 'shape', 'radius')) == 'geometries[3].shape.radius'
    assert key_text(()) == ''


@pytest.mark.parametrize(
    ('text', 'value'),
    [
        ('1e-3', 0.001),
        ('.5', 0.5),
        ('5.', 5.0),
        ('-2', -2),
        ('true', True),
        ('~', None),
        ('', None),
        ('on', 'on'),
        ('yes', 'yes'),
        ('1:30', '1:30'),
        ('2020-01-01', '2020-01-01'),
        ('0x10', '0x10'),
        ('1_000', '1_000'),
        ('"1e-3"', '1e-3'),
        ("'true'", 'true'),
        ('left::panda_hand', 'left::panda_hand'),
        ('9223372036854775807', 2**63 - 1),
    ],
)
def test_scalars_follow_yaml_1_2(text, value):
    read = read_yaml(f'k: {text}', 'a.yaml').value['k']
    assert read == value
    assert type(read) is type(value)


@pytest.mark.parametrize(
    ('text', 'line', 'key', 'part'),
    [
        ('a: &x [1]\nb: *x', 2, 'b', 'alias *x'),
        ('a: 1\nb:\n  a: 2\n  a: 3', 4, 'b', "key 'a' is listed twice, first in line 3"),
        ('a: !!python/object/apply:os.system [x]', 1, 'a', 'tag'),
        ('a:\n - !t x', 2, 'a[0]', 'tag !t'),
        ('[1]: 2', 1, '', 'a key must be text'),
        ('{a: 1}: 2', 1, '', 'a key must be text'),
        ('a: .inf', 1, 'a', '.inf must be a finite number'),
        ('a: [0, -.inf]', 1, 'a[1]', '-.inf must be a finite number'),
        ('a: .nan', 1, 'a', 'finite'),
        ('a: 1e400', 1, 'a', '1e400 must be a finite number'),
        ('a: 9223372036854775808', 1, 'a', '64 bits'),
        ('a: ' + '9' * 5000, 1, 'a', '64 bits'),
        ('a: 1\n---\nb: 2', 2, '', 'second document'),
        ('a: [1, 2', 1, '', 'not YAML'),
        ('a: 1\n\tb: 2', 2, '', 'not YAML'),
        ('a: 1\nb: "x', 2, '', 'not YAML'),
    ],
)
def test_what_is_refused_names_line_and_key(text, line, key, part):
    error = fault(text)
    assert part in error.reason
    assert error.key == key
    assert error.line == line


@pytest.mark.parametrize('text', ['', '# only a comment\n', '\n'])
def test_an_empty_text_is_refused(text):
    assert 'is empty' in fault(text).reason


@pytest.mark.parametrize('text', ['a: \x00', 'a: \ud800'])
def test_characters_that_yaml_has_not_are_refused(text):
    assert 'not YAML' in fault(text).reason


def test_a_billion_laughs_is_refused_at_the_first_alias():
    lines = ['a0: &a0 [x, x]'] + [f'a{k}: &a{k} [*a{k - 1}, *a{k - 1}]' for k in range(1, 60)]
    error = fault('\n'.join(lines))
    assert (error.line, error.key) == (2, 'a1[0]')


def test_depth_is_bounded_without_recursion():
    too_deep = f'nested more than {yaml_text.MAX_DEPTH} deep'
    assert fault('[' * (yaml_text.MAX_DEPTH + 1)).reason == too_deep
    # PyYAML 6.0.4 has a bound of its own, before events come.
    of_libyaml = 'not YAML: exceeded maximum nesting depth'
    assert fault('[' * 100_000).reason in (too_deep, of_libyaml)
    deep = '[' * yaml_text.MAX_DEPTH + ']' * yaml_text.MAX_DEPTH
    assert read_yaml(deep, 'a.yaml').value is not None


def test_size_is_bounded(monkeypatch):
    monkeypatch.setattr(yaml_text, 'MAX_BYTES', 8)
    assert read_yaml('a: 1234\n', 'a.yaml').value == {'a': 1234}
    assert fault('a: 12345\n').reason == '9 bytes; at most 8 are read'
    assert fault('a: äää\n').reason == '10 bytes; at most 8 are read'


def test_the_parser_in_python_reads_the_same(monkeypatch):
    text = 'a: [1, {b: x}]\nc: "d"\n'
    expected = read_yaml(text, 'a.yaml')
    monkeypatch.setattr(yaml_text, '_LOADER', yaml.BaseLoader)
    assert read_yaml(text, 'a.yaml') == expected


VALUES = st.recursive(
    st.none()
    | st.booleans()
    | st.integers(-(2**63), 2**63 - 1)
    | st.floats(allow_nan=False, allow_infinity=False)
    | st.sampled_from(['a', 'left::hand', 'x/y', 'b c']),
    lambda inner: (
        st.lists(inner, max_size=3)
        | st.dictionaries(st.sampled_from(['p', 'q', 'r']), inner, max_size=3)
    ),
    max_leaves=12,
)


@given(VALUES)
def test_reads_what_pyyaml_writes(value):
    text = yaml.safe_dump({'v': value})
    read = read_yaml(text, 'a.yaml')
    assert read.value == {'v': value}
    assert set(read.lines.values()) <= set(range(1, text.count('\n') + 2))
    if isinstance(value, float):
        assert math.copysign(1, read.value['v']) == math.copysign(1, value)


def test_an_emptied_document_leaves_alone_what_others_have_of_it():
    document = read_yaml(
        'name: cell\nframes:\n- {name: a, pose: [1, 2]}\n- {name: b}', 'cups.yaml'
    )
    first, frames = document.value['frames'][0], document.value['frames']
    document.free()
    assert (document.value, document.lines) == ({}, {})
    with pytest.raises(KeyError):
        document.at('frames', 0)
    assert first == {'name': 'a', 'pose': [1, 2]}
    assert frames == [first, {'name': 'b'}]
