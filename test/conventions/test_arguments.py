"""Compiled functions take few arguments, and records where these cost nothing measurable."""

import ast

from conventions.source_tree import PACKAGE, SOURCES

MOST = 8
DECORATORS = {'compiled', 'inlined', 'allocating', 'made', 'view'}
_CELLS = 'of the inner loop over neighbours: to hand ``Boxes`` on takes as long as the look'
_EPA = 'EPA grows in arrays one by one: as a record they made it take an eighth longer'
_HULLS = 'called in the loop of ``answer_pairs``, with what that has at hand'
_RAYS = 'of the inner loop over pixels, in numbers'
# By file and name: why more.
MORE = {
    '_proximity/kernels/cores/epa_witnesses.py witness': _EPA,
    '_proximity/kernels/cores/polytope.py expand': _EPA,
    '_proximity/kernels/cores/remembered.py grown': _EPA,
    '_proximity/near/grid_pairs.py _among': _CELLS,
    '_proximity/near/grid_pairs.py _look': _CELLS,
    '_proximity/pairs/coarse_hulls.py by_coarse_hulls': _HULLS,
    '_proximity/pairs/coarse_hulls.py hit_or_call': _HULLS,
    '_proximity/pairs/kernel_calls.py call_in_order': _HULLS,
    '_proximity/pairs/narrow_phase.py answer_pairs': (
        'called for each pair of many states: a record made before the loop over pairs made it '
        'take half as long again'
    ),
    '_rendering/kernels/rays.py interval': _RAYS,
    '_rendering/kernels/triangles.py triangle_window': _RAYS,
}


def long_lists(path):
    """Return the compiled functions of a file that take more than MOST arguments."""
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.FunctionDef):
            names = {getattr(each, 'id', '') for each in node.decorator_list}
            if names & DECORATORS and len(node.args.args) + len(node.args.kwonlyargs) > MOST:
                yield f'{path.relative_to(PACKAGE / "geometry").as_posix()} {node.name}'


def test_compiled_functions_take_few_arguments():
    room = PACKAGE / 'geometry'
    found = {name for path in SOURCES if room in path.parents for name in long_lists(path)}
    assert found == set(MORE)  # who needs more gives a reason; who no longer does goes


def test_a_long_list_is_seen(tmp_path):
    path = PACKAGE / 'geometry' / 'none.py'
    text = '@compiled\ndef f(a, b, c, d, e, f, g, h, i): ...\n@inlined\ndef g(a, b): ...\n'

    class Text:
        @staticmethod
        def read_text():
            return text

        relative_to = staticmethod(path.relative_to)

    assert list(long_lists(Text)) == ['none.py f']
