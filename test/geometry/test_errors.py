"""The tree of errors is the one its docstring draws."""

import inspect

from drake_geom_ros.geometry import errors


def test_the_docstring_draws_the_tree():
    drawn = {line.split()[0] for line in errors.__doc__.splitlines() if line.startswith('    ')}
    classes = {name: cls for name, cls in vars(errors).items() if inspect.isclass(cls)}
    assert drawn == {'RuntimeError', *classes}
    assert all(issubclass(cls, errors.GeometryError) for cls in classes.values())
    assert errors.GeometryError.__bases__ == (RuntimeError,)
    assert issubclass(errors.ArgumentError, ValueError)
    assert issubclass(errors.ArgumentTypeError, TypeError)
