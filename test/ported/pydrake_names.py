"""The public names of pydrake, and the arguments of what this package has too.

``python test/ported/pydrake_names.py`` writes pydrake_names.json, which stands for pydrake where
that is not installed; a test holds the two alike.
"""

import enum
import importlib
import importlib.metadata
import inspect
import json
import re
from pathlib import Path

RECORDED = Path(__file__).with_suffix('.json')
MODULES = {
    'geometry': 'pydrake.geometry',
    'math': 'pydrake.math',
    'common': 'pydrake.common',
    'common.value': 'pydrake.common.value',
    'common.eigen_geometry': 'pydrake.common.eigen_geometry',
    'sensors': 'pydrake.systems.sensors',
}
# Of these modules geometry needs a few classes only, and the rest is not its business.
IN_PART = ('common', 'common.value', 'common.eigen_geometry', 'sensors')


def ours(module):
    """Return the module of ours that stands for one of pydrake's."""
    return importlib.import_module(f'drake_geom_ros.{module}')


def arguments(name, doc):
    """Return the names of the arguments of each overload that a docstring of pydrake tells.

    An argument that may be left out ends in ``=``; one without a name is ``arg0`` and so on.
    Before 1.58 the bindings are by pybind11, since then by nanobind, which puts ``/`` behind them.
    """
    overloads = []
    for line in (doc or '').splitlines():
        match = re.match(rf'(?:\d+\. )?{re.escape(name)}\((.*)\) -> ', line)
        if match and match[1] != '*args, **kwargs':
            names = []
            for text in _split(match[1]):
                kind = text.partition(':')[0].strip()
                if kind == '/':
                    names = [f'arg{k}' for k in range(len(names))]
                elif kind != 'self':
                    names.append(kind + ('=' if ' = ' in text else ''))
            overloads.append(names)
    return overloads


def _split(text):
    """Return the arguments between the commas that are in no bracket."""
    parts, depth = [''], 0
    for letter in text:
        depth += (letter in '[({') - (letter in '])}')
        if letter == ',' and not depth:
            parts.append('')
        else:
            parts[-1] += letter
    return [part.strip() for part in parts if part.strip()]


def public(thing):
    """Return the public names of a module or a class, without those of pybind11's templates."""
    names = [name for name in dir(thing) if not name.startswith('_') and name.isascii()]
    if not inspect.ismodule(thing):
        return names
    return [n for n in names if not inspect.ismodule(getattr(thing, n)) and n != 'all']


def described(theirs, mine):
    """Return the overloads of a function, or those of every method of a class that we have."""
    if not inspect.isclass(theirs):
        return arguments(getattr(theirs, '__name__', ''), theirs.__doc__)
    if mine is None:
        return None
    if issubclass(theirs, enum.Enum):
        return {name: [] for name in theirs.__members__}
    # What every system of pydrake has says nothing of geometry.
    inherited = set(dir(theirs.__mro__[1])) if theirs.__name__ == 'SceneGraph' else set()
    methods = ['__init__', *(name for name in public(theirs) if name not in inherited)]
    return {name: arguments(name, getattr(theirs, name).__doc__) for name in methods}


def pydrakes():
    """Return modules, their names and the arguments, as pydrake has them."""
    found = {}
    for module, path in MODULES.items():
        theirs, mine = importlib.import_module(path), ours(module)
        names = public(theirs)
        if module in IN_PART:
            names = [name for name in names if hasattr(mine, name)]
        found[module] = {
            name: described(getattr(theirs, name), getattr(mine, name, None)) for name in names
        }
    return found


def recorded():
    """Return what ``pydrakes`` returned when the file was written."""
    return json.loads(RECORDED.read_text())['modules']


def changes(before, after):
    """Return what names one record has that another lacks: (new, gone), sorted."""
    every = []
    for modules in (before, after):
        names = {f'{module}.{name}' for module, found in modules.items() for name in found}
        for module, found in modules.items():
            for name, said in found.items():
                names |= {
                    f'{module}.{name}.{method}' for method in said or () if isinstance(said, dict)
                }
        every.append(names)
    old, new = every
    return sorted(new - old), sorted(old - new)


def written(modules, version):
    """Return the text of the record, with a line for each method."""
    lines = [f'{{"version": "{version}", "modules": {{']
    for module, names in modules.items():
        lines.append(f'"{module}": {{')
        for name, said in names.items():
            if isinstance(said, dict):
                methods = ',\n'.join(f'  "{m}": {json.dumps(said[m])}' for m in said)
                lines.append(f' "{name}": {{\n{methods}\n }},')
            else:
                lines.append(f' "{name}": {json.dumps(said)},')
        lines[-1] = lines[-1].removesuffix(',')
        lines.append('},')
    lines[-1] = '}'
    return '\n'.join([*lines, '}}', ''])


if __name__ == '__main__':
    RECORDED.write_text(written(pydrakes(), importlib.metadata.version('drake')))
