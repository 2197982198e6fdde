"""What compiled functions call: versions of functions that have no machine code of their own.

Of each function Numba makes one for compiled callers, one for Python and one for C, optimises all
three, with everything that they call, and emits machine code; each caller then optimises once more
what it takes over. Here the version for compiled callers stays as it was lowered, beside those
that it calls, and is optimised where it ends up: in what Python calls, or an address stands for.
Compiling everything takes about half as long; pairs of hulls take 2 to 5 % less time for it, and
pairs with an ellipsoid 1 to 4 % more (``bench/kernels.py``).

These versions are not kept on disk: what is, is complete without them, and whoever compiles
something new makes anew those that it calls. So code of one process never meets that of another.

Relied on, of Numba as it is pinned: a pass of the pipeline makes the library unless there is one;
``no_compile`` leaves the library as it is; a library finalizes itself before it is linked into
another; a call is typed by ``get_call_template`` and found by ``get_overload``.
"""

from __future__ import annotations

from typing import Any

from llvmlite import binding
from numba.core import compiler, typed_passes
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler_machinery import register_pass
from numba.core.registry import CPUDispatcher


class _Library(JITCodeLibrary):  # type: ignore[misc]
    """Functions as they were lowered, to be linked into others; no engine ever sees them."""

    def finalize(self) -> None:
        for library in dict.fromkeys(self._linking_libraries):
            self._reload_init.update(library._reload_init)
            self._final_module.link_in(library._get_module_for_linking(), preserve=True)
        for function in self._final_module.functions:
            if not function.is_declaration and function.linkage == binding.Linkage.external:
                function.linkage = 'linkonce_odr'  # left out by whoever does not call it
        self._finalize_dynamic_globals()
        self._shared_module = self._final_module
        self._finalized = True


@register_pass(mutates_CFG=True, analysis_only=False)
class _Lowering(typed_passes.NativeLowering):  # type: ignore[misc]
    """Lowers a function into such a library."""

    _name = 'lowering_for_compiled_callers'

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

    def _optimize_final_module(self) -> None:
        super()._optimize_final_module()
        super()._optimize_final_module()


@register_pass(mutates_CFG=True, analysis_only=False)
class _EntryLowering(typed_passes.NativeLowering):  # type: ignore[misc]
    """Lowers a function into such a library."""

    _name = 'lowering_for_python'

    def run_pass(self, state: Any) -> bool:
        if state.library is None:
            state.library = _EntryLibrary(state.targetctx.codegen(), state.func_id.func_qualname)
            state.library.enable_object_caching()
        changed: bool = super().run_pass(state)
        return changed


class _Pipeline(compiler.CompilerBase):  # type: ignore[misc]
    lowering = _Lowering

    def define_pipelines(self) -> list[Any]:
        manager = compiler.DefaultPassBuilder.define_nopython_pipeline(self.state)
        manager.passes = [
            (self.lowering if each is typed_passes.NativeLowering else each, text)
            for each, text in manager.passes
        ]
        manager._finalized = False
        manager.finalize()
        return [manager]


class EntryPipeline(_Pipeline):
    """How functions that Python calls, or an address stands for, are compiled."""

    lowering = _EntryLowering


class _Called(CPUDispatcher):  # type: ignore[misc]
    """A function for compiled callers; Python cannot call it."""

    def add_overload(self, cres: Any) -> None:
        self.overloads[tuple(cres.signature.args)] = cres


def version_for_compiled_callers(dispatcher: Any) -> Any:
    """Return the version of a function that compiled code is to call."""
    wrappers = {'no_cpython_wrapper': True, 'no_cfunc_wrapper': True}
    options = {**dispatcher.targetoptions, **wrappers}
    return _Called(dispatcher.py_func, targetoptions=options, pipeline_class=_Pipeline)
