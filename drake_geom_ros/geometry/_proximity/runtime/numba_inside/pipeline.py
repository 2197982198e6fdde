"""What compiled functions call are versions of functions that have no machine code of their own.

Of each function Numba makes one for compiled callers, one for Python and one for C, optimises all
three, with everything that they call, and emits machine code; each caller then optimises once more
what it takes over. Here the version for compiled callers stays as it was lowered, beside those
that it calls, and is optimised where it ends up: in what Python calls, or an address stands for.
Compiling everything takes about half as long; pairs of hulls take 2 to 5 % less time for it, and
pairs with an ellipsoid 1 to 4 % more (``bench/costs/kernels.py``).

These versions are not kept on disk: what is, is complete without them, and whoever compiles
something new makes anew those that it calls. So code of one process never meets that of another.

Relied on: a pass of the pipeline makes the library unless there is one; ``no_compile`` leaves the
library as it is; a library finalizes itself before it is linked into another; a call is typed by
``get_call_template`` and found by ``get_overload``; with ``_nrt`` False no reference to an array
is counted; a dispatcher has its versions as ``overloads``, and these the name of their wrapper for
C.
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
    """Functions as they were lowered, to be linked into others; no engine ever sees them."""

    _shared_module: Any

    def finalize(self) -> None:
        for library in dict.fromkeys(self._linking_libraries):
            self._reload_init.update(library._reload_init)
        for function in self._final_module.functions:
            if not function.is_declaration and function.linkage == binding.Linkage.external:
                function.linkage = 'linkonce_odr'  # left out by whoever does not call it
        self._finalized = True

    def _get_module_for_linking(self) -> Any:
        """Return these functions with all that they call, for a library that is not ours."""
        if self._shared_module is None:
            whole = self._final_module.clone()
            for library in _called_by(self):
                whole.link_in(_module_of(library), preserve=True)
            self._shared_module = whole
        return self._shared_module


def _module_of(library: Any) -> Any:
    """Return what a library has to be linked beside what ``_called_by`` returns."""
    if isinstance(library, _Library):
        return library._final_module
    return library._get_module_for_linking()


def _called_by(library: Any) -> list[Any]:
    """Return all libraries that a library calls, each once, callers before those that they call.

    Each is linked where code is emitted; linked into each caller, they were copied a dozen times.
    What nobody calls yet when it is linked LLVM leaves out, hence the order.
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
    """Lowers a function into such a library."""

    _name = 'lowering_for_compiled_callers'
    lowering_class = Lower

    def run_pass(self, state: Any) -> bool:
        state.library = _Library(state.targetctx.codegen(), state.func_id.func_qualname)
        state.flags.no_compile = True
        changed: bool = super().run_pass(state)
        lowered = state['cr']
        key = lowered.fndesc  # for the function that there is not
        state.targetctx.insert_user_function(key, lowered.fndesc, [state.library])
        state['cr'] = lowered._replace(cfunc=key)
        return changed


class _EntryLibrary(JITCodeLibrary):  # type: ignore[misc]
    """What Python calls, optimised twice.

    What it calls was inlined before its loops were seen to: points of hulls took 25 % longer, all
    pairs of mixed shapes 10 %. The second time costs next to nothing.
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
        if any(name.startswith('_ZN') for name in missing):  # a call of it would end the process
            raise AssertionError(f'{self.name} calls what was not linked: {missing}')

    def _optimize_final_module(self) -> None:
        super()._optimize_final_module()
        super()._optimize_final_module()


@register_pass(mutates_CFG=True, analysis_only=False)
class _EntryLowering(typed_passes.NativeLowering):  # type: ignore[misc]
    """Lowers a function into such a library."""

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
    """How functions that Python calls, or an address stands for, are compiled."""

    lowering = _EntryLowering


def options(counted: bool) -> dict[str, Any]:
    """Return the options of a function: ``counted`` says whether it counts references to arrays.

    One that does not say so inherits that from whoever asks for it first.
    """
    return {'_nrt': counted, 'pipeline_class': _EntryPipeline}


def for_compiled_callers(dispatcher: Any, constants: bool) -> Any:
    """Return the dispatcher, which has compiled code call what has no machine code of its own.

    With ``constants`` there is one version for each constant that it is called with. Else there is
    one for all numbers: one for each took half of the time to compile everything, and LLVM knows
    the constants where it inlines.
    """

    @functools.cache  # made when first called for: it takes time that an import need not
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
    """Return the address of a function of some signature for C.

    ``numba.cfunc`` makes a second version of it, which nobody hears of who listens for what is
    compiled.
    """
    function.compile(signature.args)
    compiled = function.overloads[signature.args]
    return compiled.library.get_pointer_to_function(compiled.fndesc.llvm_cfunc_wrapper_name)
