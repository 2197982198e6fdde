"""Compiled functions as bytes, and back, in a process that has compiled nothing.

Numba's own way keeps the intermediate code beside the object code, for callers that link it in,
and prepares everything that a compiler needs before it loads anything: 0.3 s of imports, with
``scipy.linalg`` among them. Here callers never link cached code (``pipeline``), so object code is
enough, beside the names of its entries. What it needs of the process is another list of names,
which are looked up first; one that is missing is looked for once more after Numba's preparation.

Relied on: the parts of ``CompileResult._reduce``; a library that is loaded as object code needs
its intermediate code for callers and for names alone; a compiler prepares its context itself.
"""

from __future__ import annotations

import functools
import io
import pickle
import sys
from typing import Any

from llvmlite import binding, ir
from numba.core import environment
from numba.core.compiler import CompileResult
from numba.core.runtime import _nrt_python
from numba.core.serialize import dumps


def is_storable(result: Any) -> bool:
    """Return whether a compiled function refers to nothing of this process alone."""
    return not result.library.has_dynamic_globals and all(each.can_cache for each in result.lifted)


def to_bytes(signature: Any, result: Any) -> bytes:
    """Return a compiled function as bytes, with the names of what it calls."""
    module = result.library._final_module
    symbols = [
        each.name
        for each in (*module.functions, *module.global_variables)
        if each.is_declaration and not each.name.startswith('llvm.')
    ]
    (name, kind, (code, _)), *others = result._reduce()
    library = name, kind, (code, _looked_up(module, result.fndesc))
    return bytes(dumps((signature, symbols, (library, *others))))


def _looked_up(module: Any, description: Any) -> bytes:
    """Return the intermediate code of a module with the functions that are looked up, empty."""
    names = ir.Module()
    wanted = {description.llvm_cpython_wrapper_name, description.llvm_cfunc_wrapper_name}
    for each in module.functions:
        if each.name in wanted and not each.is_declaration:
            function = ir.Function(names, ir.FunctionType(ir.VoidType(), ()), each.name)
            ir.IRBuilder(function.append_basic_block()).ret_void()
    return bytes(binding.parse_assembly(str(names)).as_bitcode())


def from_bytes(content: bytes, signature: Any, context: Any) -> Any:
    """Return a compiled function, or None where it cannot be loaded into this process."""
    try:
        its_signature, symbols, parts = _Reader(io.BytesIO(content)).load()
    except Exception:  # whatever a type of another NumPy raises when it is read
        return None
    if its_signature != signature:
        return None
    _add_runtime()
    if not _are_there(symbols):
        context.refresh()
        if not _are_there(symbols):  # to load it would end the process
            return None
    return CompileResult._rebuild(context, *parts)


class _Reader(pickle.Unpickler):
    """Reads compiled functions, without an import of those modules of Numba that they came from.

    ``numba.np.arraymath`` imports ``scipy.linalg``: 0.2 s.
    """

    def find_class(self, module: str, name: str) -> Any:
        if (module, name) == (environment.__name__, environment._rebuild_env.__name__):
            return _environment
        return super().find_class(module, name)


def _environment(module: str, constants: list[Any], name: str) -> Any:
    """Return the environment of a function, by its name the only one in this process.

    Only code that is not compiled looks up globals there.
    """
    existing = environment.lookup_environment(name)
    if existing is not None or module in sys.modules or not module.startswith('numba.'):
        return environment._rebuild_env(module, constants, name)
    its_own = environment.Environment({'__name__': module})
    its_own.consts[:] = constants
    its_own.env_name = name
    environment.Environment._memo[name] = its_own
    return its_own


def _are_there(symbols: list[str]) -> bool:
    return all(binding.address_of_symbol(name) is not None for name in symbols)


@functools.cache
def _add_runtime() -> None:
    """Name the functions of Numba's runtime, as its initialisation does before it compiles."""
    for name, address in _nrt_python.c_helpers.items():
        binding.add_symbol(name if name.startswith('_') else f'NRT_{name}', address)
