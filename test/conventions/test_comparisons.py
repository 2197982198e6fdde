"""What tests compare numbers by: NumPy adds a relative tolerance where nobody asks for one."""

import ast

from conventions.source_tree import ROOT, name_of
from every import report

TESTS = sorted((ROOT / 'test').rglob('*.py'))
COMPARISONS = ('assert_allclose', 'allclose', 'isclose')


def unsaid(source):
    """Return the lines of comparisons by ``atol`` alone, which are by an ``rtol`` too."""
    calls = [node for node in ast.walk(ast.parse(source)) if isinstance(node, ast.Call)]
    lines = []
    for call in calls:
        name = getattr(call.func, 'attr', getattr(call.func, 'id', ''))
        said = {keyword.arg for keyword in call.keywords}
        if name in COMPARISONS and len(call.args) < 3 and 'atol' in said and 'rtol' not in said:
            lines.append(call.lineno)
    return lines


def test_a_comparison_by_atol_says_rtol():
    assert len(TESTS) > 500
    report(f'{name_of(path)}:{line}' for path in TESTS for line in unsaid(path.read_text()))


def test_one_that_does_not_is_seen():
    source = 'np.testing.assert_allclose(a, b, atol=1e-9)\nnp.isclose(a, b, rtol=0, atol=1e-9)'
    assert unsaid(source) == [1]
