"""A private name belongs to the file that makes it: no other one reads it of an object."""

import ast

from conventions.source_tree import PACKAGE, SOURCES, imports_of, name_of
from every import report

# Of libraries, where they have no public way: names, and what they are read for.
ALLOWED = {
    'command_line/configurations.py': {'_MutuallyExclusiveGroup'},  # a type; argparse exports none
    # Numba's compiled libraries, under a check of its version.
    'geometry/_proximity/runtime/numba_inside/pipeline.py': {'_final_module', '_reload_init'},
    'geometry/_proximity/runtime/numba_inside/array_views.py': {'_getvalue'},
    'geometry/_proximity/runtime/numba_inside/object_code.py': {
        *('_final_module', '_memo', '_rebuild', '_rebuild_env', '_reduce'),
    },
    'geometry/_proximity/runtime/numba_inside/shared_cache.py': {
        *('_cache', '_compilation_chain_init_hook'),
    },
    'math/missing.py': {'_getframe'},  # who asks; inspect.stack() reads source files
    'programs.py': {'_exit'},  # whatever is imported
    'ros/parameters.py': {'_parameter_overrides', '_parameters'},  # what a node was started with
    'ros/surface.py': {'_parameter_overrides'},
    'ros/sensing/__main__.py': {'_exit'},  # whatever it does, when its node is gone
    'ros/spinning.py': {'_executor_event', '_exit'},  # as rclpy's own executors mark entities
    'live/watchdog.py': {
        '_current_frames',
        '_exit',
    },  # Python's documented way out of a hung process
}
OF_TUPLES = {'_asdict', '_fields', '_make', '_replace'}  # documented of NamedTuple


def own_names(tree):
    """Return the names that a file makes: of functions, classes, fields and attributes of self."""
    names = set()
    for node in ast.walk(tree):
        if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef, ast.ClassDef)):
            names.add(node.name)
        if isinstance(node, ast.Attribute) and isinstance(node.ctx, ast.Store):
            names |= {node.attr} if is_self(node.value) else set()
        if isinstance(node, ast.ClassDef):
            for line in node.body:
                targets = getattr(line, 'targets', [getattr(line, 'target', None)])
                names |= {target.id for target in targets if isinstance(target, ast.Name)}
    return names


def is_self(node):
    if isinstance(node, ast.Call):  # super()._name
        return isinstance(node.func, ast.Name) and node.func.id == 'super'
    return isinstance(node, ast.Name) and node.id in ('self', 'cls')


def foreign_names(tree):
    """Return the private names of other objects that a file reads and does not make, by line."""
    allowed = own_names(tree) | OF_TUPLES
    return {
        (node.lineno, node.attr)
        for node in ast.walk(tree)
        if isinstance(node, ast.Attribute)
        and node.attr.startswith('_')
        and not node.attr.startswith('__')
        and node.attr not in allowed
        and not is_self(node.value)
    }


def test_no_file_reads_private_names_of_what_others_make():
    report(
        f'{name_of(path)}:{line}: {name}'
        for path in SOURCES
        for line, name in sorted(foreign_names(ast.parse(path.read_text())))
        if name not in ALLOWED.get(path.relative_to(PACKAGE).as_posix(), ())
    )


INSIDE = 'geometry/_proximity/runtime/numba_inside/'
# Of Numba's inner packages what its manual documents for others.
DOCUMENTED = ('numba.core.event', 'numba.core.cgutils')


def inside_numba(source):
    """Return the inner modules of Numba that a source imports and no manual documents."""
    inner = [n for n in imports_of(source) if n.startswith(('numba.core', 'numba.np'))]
    return [name for name in inner if name not in DOCUMENTED]


def test_one_room_relies_on_the_inside_of_numba():
    outside = [
        path for path in SOURCES if not path.relative_to(PACKAGE).as_posix().startswith(INSIDE)
    ]
    assert 0 < len(outside) < len(SOURCES)
    report(f'{name_of(p)}: {name}' for p in outside for name in inside_numba(p.read_text()))


def test_the_inside_of_numba_is_seen():
    source = 'from numba.core import cgutils, types\nimport numba.np.arrayobj\nimport numba'
    assert inside_numba(source) == ['numba.core.types', 'numba.np.arrayobj']


def test_what_is_allowed_is_needed():
    for path, names in ALLOWED.items():
        found = foreign_names(ast.parse((PACKAGE / path).read_text()))
        assert {name for _, name in found} == names


def test_a_private_name_of_another_file_is_seen():
    text = 'class A:\n    _x = 0\n    def f(self, o):\n        return o._x, self._y, o.z._w'
    assert foreign_names(ast.parse(text)) == {(4, '_w')}
