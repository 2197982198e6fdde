"""Reduced front end of Numba, for the code of this package.

Half of the work of the full front end is for features that this code does not use: passes for
closures, literals and generators, live variables computed again after each pass, and a search
through dozens of templates for the type of ``a * b`` of two floats, repeated for each of ten
thousand operations.

Assumptions, beside those in ``pipeline``:

- Code without closures, ``with`` and ``literal_unroll`` needs none of the omitted passes, and code
  with them fails to compile.
- ``IRLegalization`` computes the live variables that the lowering needs.
- ``_runPass`` runs one pass, and our passes need no other hook of it.
- The typing of operators and functions on plain numbers never changes.
"""

from __future__ import annotations

import functools
import operator
from typing import Any

from numba import types
from numba.core import (
    compiler,
    errors,
    event,
    ir,
    lowering,
    sigutils,
    typed_passes,
    untyped_passes,
)
from numba.core.compiler_lock import global_compiler_lock
from numba.core.compiler_machinery import PassManager, register_pass
from numba.core.registry import CPUDispatcher

_LEFT_OUT = (
    untyped_passes.WithLifting,
    untyped_passes.InlineClosureLikes,
    untyped_passes.MakeFunctionToJitFunction,
    untyped_passes.RewriteDynamicRaises,
    untyped_passes.InlineInlinables,
    untyped_passes.FindLiterallyCalls,
    untyped_passes.LiteralUnroll,
    untyped_passes.LiteralPropagationSubPipelinePass,
    typed_passes.InlineOverloads,
    typed_passes.NopythonRewrites,
    typed_passes.NoPythonSupportedFeatureValidation,
    typed_passes.AnnotateTypes,
    typed_passes.DumpParforDiagnostics,
)


_OF_ARRAYS = (operator.getitem, operator.setitem)


def _is_plain(kind: Any) -> bool:
    """Return whether operations on a type are built into Numba, so their typing is constant."""
    if isinstance(kind, types.BaseTuple):
        return all(map(_is_plain, kind))
    return isinstance(kind, (types.Number, types.Boolean))


class _Typing:
    """Typing context that caches the types of operations on plain numbers and their arrays."""

    def __init__(self, context: Any) -> None:
        self._context = context
        self._cache: dict[Any, tuple[Any, Any]] = {}

    def __getattr__(self, name: str) -> Any:
        return getattr(self._context, name)

    def resolve_function_type(self, function: Any, args: Any, kws: Any) -> Any:
        """Return the signature of a function for given argument types."""
        if isinstance(function, types.Function) and not kws and args:
            first, *others = args
            of_array = function.typing_key in _OF_ARRAYS and isinstance(first, types.Array)
            if all(map(_is_plain, others if of_array else args)):
                return self._recalled(function, tuple(args))
        return self._context.resolve_function_type(function, args, kws)

    def resolve_getitem(self, target: Any, index: Any) -> Any:
        """Return the signature of reading an element."""
        function = self._context.resolve_value_type(operator.getitem)
        return self.resolve_function_type(function, (target, index), {})

    def resolve_setitem(self, target: Any, index: Any, value: Any) -> Any:
        """Return the signature of writing an element."""
        function = self._context.resolve_value_type(operator.setitem)
        return self.resolve_function_type(function, (target, index, value), {})

    def _recalled(self, function: Any, args: Any) -> Any:
        key = id(function), args
        entry = self._cache.get(key)
        if entry is None:
            signature = self._context.resolve_function_type(function, args, {})
            if signature is None:
                return None
            entry = self._cache[key] = function, signature  # alive, so the id stays unique
        return entry[1]


_typing = functools.cache(_Typing)


@register_pass(mutates_CFG=True, analysis_only=False)
class _TypeInference(typed_passes.NopythonTypeInference):  # type: ignore[misc]
    """Type inference with a caching context."""

    _name = 'type_inference_by_memory'

    def run_pass(self, state: Any) -> bool:
        context = state.typingctx
        state.typingctx = _typing(context)
        try:
            changed: bool = super().run_pass(state)
        finally:
            state.typingctx = context
        return changed


class Lower(lowering.Lower):  # type: ignore[misc]
    """Lowering that reuses inferred signatures instead of resolving them again."""

    def lower_binop(self, resty: Any, expr: Any, op: Any) -> Any:
        """Lower a binary operation."""
        if not (expr.static_lhs is ir.UNDEFINED and expr.static_rhs is ir.UNDEFINED):
            return super().lower_binop(resty, expr, op)
        function = self.context.typing_context.resolve_value_type(op)
        return self._called(function, self.fndesc.calltypes[expr], (expr.lhs, expr.rhs), resty)

    def lower_getitem(self, resty: Any, expr: Any, value: Any, index: Any, signature: Any) -> Any:
        """Lower the reading of an element."""
        function = self.context.typing_context.resolve_value_type(operator.getitem)
        return self._called(function, signature, (value, index), resty)

    def lower_setitem(self, target: Any, index: Any, value: Any, signature: Any) -> Any:
        """Lower the writing of an element."""
        function = self.context.typing_context.resolve_value_type(operator.setitem)
        return self._called(function, signature, (target, index, value), None)

    def _called(self, function: Any, signature: Any, variables: Any, kind: Any) -> Any:
        """Generate a call, and cast its result to ``kind`` unless that is None."""
        try:
            implementation = self.context.get_function(function, signature)
        except KeyError:  # the signature was derived from that of other types
            own_signature = function.get_call_type(self.context.typing_context, signature.args, {})
            implementation = self.context.get_function(function, own_signature)
        arguments = [
            self.context.cast(self.builder, self.loadvar(each.name), self.typeof(each.name), to)
            for each, to in zip(variables, signature.args, strict=True)
        ]
        result = implementation(self.builder, arguments)
        if kind is None:
            return result
        return self.context.cast(self.builder, result, signature.return_type, kind)


class _Manager(PassManager):  # type: ignore[misc]
    """Pass manager without timing and notification of each pass."""

    def _runPass(self, index: int, each: Any, state: Any) -> None:
        each.analysis = self._analysis
        with errors.new_error_context('Pass {name}', name=each.name()):
            each.run_initialization(state)
            each.run_pass(state)
            each.run_finalizer(state)


class Pipeline(compiler.CompilerBase):  # type: ignore[misc]
    """Compiler of a function, lowered by the pass ``lowering``."""

    lowering: Any = typed_passes.NativeLowering

    def define_pipelines(self) -> list[Any]:
        """Return the passes."""
        manager = _Manager('nopython')
        plain = compiler.DefaultPassBuilder.define_nopython_pipeline(self.state)
        replacements = {
            typed_passes.NativeLowering: self.lowering,
            typed_passes.NopythonTypeInference: _TypeInference,
        }
        for each, text in plain.passes:
            if each not in _LEFT_OUT:
                manager.add_pass(replacements.get(each, each), text)
        manager.finalize()
        return [manager]


class Called(CPUDispatcher):  # type: ignore[misc]
    """Dispatcher of a function for compiled callers, which Python cannot call."""

    def add_overload(self, cres: Any) -> None:
        """Register a compiled version."""
        self.overloads[tuple(cres.signature.args)] = cres

    def compile(self, sig: Any) -> Any:
        """Compile a version unless it exists, without measuring lock times."""
        args, return_type = sigutils.normalize_signature(sig)
        existing = self.overloads.get(args)
        if existing is not None:
            return existing.entry_point
        with global_compiler_lock, self._compiling_counter:
            details = {'dispatcher': self, 'args': args, 'return_type': return_type}
            with event.trigger_event('numba:compile', data=details):
                made = self._compiler.compile(args, return_type)
            self.add_overload(made)
        return made.entry_point
