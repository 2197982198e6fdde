"""Compiler pipeline in which functions for compiled callers get no machine code of their own.

For each function, Numba makes a version for compiled callers, one for Python and one for C. It
optimises all three with everything that they call and emits machine code; each caller then
optimises the inlined code again. Here the version for compiled callers stays as lowered, and is
optimised only in its final place: in functions that Python calls or that have an address.
Compiling everything takes about half as long. Pairs of hulls become 2 to 5 % faster and pairs with
an ellipsoid 1 to 4 % slower (``bench/costs/kernels.py``).

These versions are not cached on disk. Cached code is complete without them, and compiling a new
function makes the versions that it calls again. So code of different processes is never combined.

Assumptions:

- A pass of the pipeline makes the library unless there is one.
- ``no_compile`` leaves the library unchanged.
- A library finalizes itself before it is linked into another.
- A call is typed by ``get_call_template`` and resolved by ``get_overload``.
- With ``_nrt`` False no reference to an array is counted.
- A dispatcher has its versions in ``overloads``, and these the name of their C wrapper.
"""

from __future__ import annotations

import functools
from typing import Any

from llvmlite import binding
from numba import types
from numba.core import typed_passes
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler_machinery import register_pass

from drake_geom_ros.geometry._proximity.runtime.numba_inside.front_end import (
    Called,
    Lower,
    Pipeline,
)


class _Library(JITCodeLibrary):  # type: ignore[misc]
    """Library of lowered functions, to be linked into others; no execution engine loads it."""

    _shared_module: Any

    def finalize(self) -> None:
        for library in dict.fromkeys(self._linking_libraries):
            self._reload_init.update(library._reload_init)
        for function in self._final_module.functions:
            if not function.is_declaration and function.linkage == binding.Linkage.external:
                function.linkage = 'linkonce_odr'  # dropped where it is not called
        self._finalized = True

    def _get_module_for_linking(self) -> Any:
        """Return these functions with all their callees, for linking into a library of Numba's."""
        if self._shared_module is None:
            whole = self._final_module.clone()
            for library in _called_by(self):
                whole.link_in(_module_of(library), preserve=True)
            self._shared_module = whole
        return self._shared_module


def _module_of(library: Any) -> Any:
    """Return the module of a library that is linked along with those of ``_called_by``."""
    if isinstance(library, _Library):
        return library._final_module
    return library._get_module_for_linking()


def _called_by(library: Any) -> list[Any]:
    """Return all libraries that a library calls, each once, callers before callees.

    Each is linked where code is emitted; linking into each caller made a dozen copies. LLVM drops
    functions that nothing calls when they are linked, hence the order.
    """
    seen: set[Any] = set()
    ordered: list[Any] = []

    def visit(each: Any) -> None:
        if each in seen:
            return
        seen.add(each)
        if each is library or isinstance(each, _Library):
            for other in each._linking_libraries:
                visit(other)
        ordered.append(each)

    visit(library)
    return ordered[-2::-1]


@register_pass(mutates_CFG=True, analysis_only=False)
class _Lowering(typed_passes.NativeLowering):  # type: ignore[misc]
    """Lowering pass that puts a function into its library."""

    _name = 'lowering_for_compiled_callers'
    lowering_class = Lower

    def run_pass(self, state: Any) -> bool:
        state.library = _Library(state.targetctx.codegen(), state.func_id.func_qualname)
        state.flags.no_compile = True
        changed: bool = super().run_pass(state)
        lowered = state['cr']
        key = lowered.fndesc  # in place of the missing compiled function
        state.targetctx.insert_user_function(key, lowered.fndesc, [state.library])
        state['cr'] = lowered._replace(cfunc=key)
        return changed


class _EntryLibrary(JITCodeLibrary):  # type: ignore[misc]
    """Library of a function that Python calls, optimised twice.

    The first time inlines callees before their loops are optimised: with it alone, points of hulls
    took 25 % longer, and all pairs of mixed shapes 10 %. The second time costs next to nothing.
    """

    _linking_libraries: list[Any]

    def finalize(self) -> None:
        for library in _called_by(self):
            self._reload_init.update(library._reload_init)
            self._final_module.link_in(_module_of(library), preserve=True)
        self._linking_libraries = []
        super().finalize()

    def _verify_declare_only_symbols(self) -> None:
        missing = [f.name for f in self._final_module.functions if f.is_declaration]
        if any(name.startswith('_ZN') for name in missing):  # calling it would crash the process
            raise AssertionError(f'{self.name} calls what was not linked: {missing}')

    def _optimize_final_module(self) -> None:
        super()._optimize_final_module()
        super()._optimize_final_module()


@register_pass(mutates_CFG=True, analysis_only=False)
class _EntryLowering(typed_passes.NativeLowering):  # type: ignore[misc]
    """Lowering pass that puts a function into its library."""

    _name = 'lowering_for_python'
    lowering_class = Lower

    def run_pass(self, state: Any) -> bool:
        if state.library is None:
            state.library = _EntryLibrary(state.targetctx.codegen(), state.func_id.func_qualname)
            state.library.enable_object_caching()
        changed: bool = super().run_pass(state)
        return changed


class _Pipeline(Pipeline):
    lowering = _Lowering


class _EntryPipeline(Pipeline):
    """Pipeline for functions that Python calls or that have an address."""

    lowering = _EntryLowering


def options(counted: bool) -> dict[str, Any]:
    """Return Numba's options of a function; ``counted``: it counts references to arrays.

    Without an explicit option a function would inherit it from its first caller.
    """
    return {'_nrt': counted, 'pipeline_class': _EntryPipeline}


def for_compiled_callers(dispatcher: Any, constants: bool) -> Any:
    """Return the dispatcher, changed to give compiled callers versions without machine code.

    With ``constants`` there is one version for each constant argument. Otherwise one version
    serves all numbers: separate ones took half of the time to compile everything, and LLVM knows
    the constants where it inlines.
    """

    @functools.cache  # made on the first call, to keep imports fast
    def called() -> Any:
        wrappers = {'no_cpython_wrapper': True, 'no_cfunc_wrapper': True}
        targeted = {**dispatcher.targetoptions, **wrappers}
        return Called(dispatcher.py_func, targetoptions=targeted, pipeline_class=_Pipeline)

    def get_call_template(args: Any, kws: Any) -> Any:
        if not constants:
            kws = {name: types.unliteral(kind) for name, kind in kws.items()}
            args = tuple(map(types.unliteral, args))
        return called().get_call_template(args, kws)

    dispatcher.get_call_template = get_call_template
    dispatcher.get_overload = lambda signature: called().get_overload(signature)
    return dispatcher


def address_of(function: Any, signature: Any) -> Any:
    """Return the address of a function for C, compiled for one signature.

    ``numba.cfunc`` would make a second version, of which listeners to compile events are not
    notified.
    """
    function.compile(signature.args)
    compiled = function.overloads[signature.args]
    return compiled.library.get_pointer_to_function(compiled.fndesc.llvm_cfunc_wrapper_name)
