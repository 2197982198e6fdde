"""Whatever keyword pydrake takes for a method that we have, ours takes too."""

import importlib.util
import inspect
import json
import warnings

import pytest
from every import check
from packaging.version import Version
from ported.pydrake_names import MODULES, RECORDED, arguments, changes, ours, pydrakes, recorded

# What is said of these stands in docs/differences_from_pydrake.md.
BY_KEYWORD_ONLY = {('geometry', 'Convex', '__init__', 'points')}

needs_pydrake = pytest.mark.skipif(
    importlib.util.find_spec('pydrake') is None, reason='pydrake is not installed'
)


@needs_pydrake
def test_the_record_is_what_pydrake_says():
    version = json.loads(RECORDED.read_text())['version']
    installed = importlib.metadata.version('drake')
    if installed.rsplit('.', 1)[0] != version.rsplit('.', 1)[0]:
        new, gone = changes(recorded(), pydrakes())
        if Version(installed) > Version(version):
            names = ', '.join(new) or 'nothing', ', '.join(gone) or 'nothing'
            text = f'pydrake {installed} is newer than the record, of {version}. New: {names[0]}. '
            text += f'Gone: {names[1]}. Run: python test/ported/pydrake_names.py'
            warnings.warn(text, stacklevel=1)
        pytest.skip(f'recorded of {version}, installed is {installed}')
    assert recorded() == pydrakes(), 'run: python test/ported/pydrake_names.py'


def test_what_is_new_is_named():
    before = {'geometry': {'A': {'f': [[]], 'g': [[]]}, 'b': [['x']], 'Gone': None}}
    after = {'geometry': {'A': {'f': [['y']], 'h': [[]]}, 'b': [['x']], 'New': None}}
    new, gone = changes(before, after)
    assert new == ['geometry.A.h', 'geometry.New']
    assert gone == ['geometry.A.g', 'geometry.Gone']


def common_calls():
    """Yield module, class or '', name, function of ours, and the overloads of pydrake."""
    for module, names in recorded().items():
        mine = ours(module)
        for name, said in names.items():
            if not said or not hasattr(mine, name):
                continue
            thing = getattr(mine, name)
            if isinstance(said, list):
                yield module, '', name, thing, said
                continue
            for method, overloads in said.items():
                if hasattr(thing, method):
                    call = thing if method == '__init__' else getattr(thing, method)
                    yield module, name, method, call, overloads


CALLS = [call for call in common_calls() if call[-1]]


def takes_its_keywords(call):
    """Assert that a function of ours binds all arguments of pydrake's overloads."""
    module, kind, name, function, overloads = call
    signature = inspect.signature(function)
    instance = [None] if next(iter(signature.parameters), '') == 'self' else []
    for names in overloads:
        plain = [name.rstrip('=') for name in names]
        if not plain or plain[0].startswith('*'):
            continue
        required = [name for name in names if not name.endswith('=')]
        if not any(name.startswith('arg') for name in plain):
            signature.bind(*instance, **dict.fromkeys(plain))
            signature.bind(*instance, **dict.fromkeys(required))
        # A context may stand before the others, which the signature of ours does not show.
        if plain[0] != 'context' and (module, kind, name, plain[0]) not in BY_KEYWORD_ONLY:
            signature.bind(*instance, *plain)
            signature.bind(*instance, *required)


def test_keywords_are_taken():
    check(takes_its_keywords, CALLS, lambda call: '.'.join(filter(None, call[:3])))


def test_a_keyword_that_is_not_taken_is_seen():
    call = ('geometry', 'Any', 'Move', lambda self, X_WG: None, [['X_WG'], ['X_WG', 'speed=']])
    with pytest.raises(TypeError, match='speed'):
        takes_its_keywords(call)


def test_the_exceptions_are_such():
    calls = {call[:3]: call for call in CALLS}
    for module, kind, name, first in BY_KEYWORD_ONLY:
        overloads = [[n.rstrip('=') for n in names] for names in calls[module, kind, name][4]]
        assert any(names and names[0] == first for names in overloads)


def test_the_record_knows_what_there_is():
    names = recorded()
    assert set(names) == set(MODULES)
    assert ['rgba'] in names['geometry']['Rgba']['set']
    assert len(CALLS) > 250


def test_how_arguments_are_read():
    doc = (
        'f(*args, **kwargs)\nOverloaded function.\n\n'
        '1. f(self: a.B, x: list[tuple[int, int]], y: float = 1.0) -> None\n\n'
        '2. f(arg0: int) -> int'
    )
    assert arguments('f', doc) == [['x', 'y='], ['arg0']]
    assert arguments('f', None) == []
