"""The mutants of a source file: what may be changed in it, one place at a time.

Cosmic Ray finds the places and makes the changes. Of its operators those are taken that change a
comparison, an arithmetic or logical operator, a constant or a loop; of the twelve things that an
operator could become, one. Annotations and decorators are left alone: they do not compute.
"""

from __future__ import annotations

import itertools
import random
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from cosmic_ray.ast import ast_nodes, get_ast
from cosmic_ray.ast.ast_query import ASTQuery
from cosmic_ray.mutating import mutate_code
from cosmic_ray.operators import (
    binary_operator_replacement,
    boolean_replacer,
    break_continue,
    comparison_operator_replacement,
    number_replacer,
    unary_operator_replacement,
    zero_iteration_for_loop,
)

_COMPARISONS = (
    *('Lt_LtE', 'Lt_GtE', 'LtE_Lt', 'LtE_Gt', 'Gt_GtE', 'Gt_LtE', 'GtE_Gt', 'GtE_Lt'),
    *('Eq_NotEq', 'NotEq_Eq', 'Is_IsNot', 'IsNot_Is'),
)
_ARITHMETIC = (
    *('Add_Sub', 'Sub_Add', 'Mul_Div', 'Div_Mul', 'FloorDiv_Mul', 'Mod_Add', 'Pow_Mul'),
    *('BitOr_BitAnd', 'BitAnd_BitOr', 'BitXor_BitAnd', 'RShift_LShift', 'LShift_RShift'),
)
_SIGNS = ('Delete_USub', 'Delete_Not', 'Delete_Invert')

# The three kinds that a sample holds alike: an array's index is a constant too, and there are more
# of these than of all else.
KINDS = {
    'comparisons': [
        *(
            getattr(comparison_operator_replacement, f'ReplaceComparisonOperator_{name}')
            for name in _COMPARISONS
        ),
        boolean_replacer.ReplaceAndWithOr,
        boolean_replacer.ReplaceOrWithAnd,
    ],
    'operators': [
        *(
            getattr(binary_operator_replacement, f'ReplaceBinaryOperator_{name}')
            for name in _ARITHMETIC
        ),
        *(getattr(unary_operator_replacement, f'ReplaceUnaryOperator_{name}') for name in _SIGNS),
        zero_iteration_for_loop.ZeroIterationForLoop,
        break_continue.ReplaceBreakWithContinue,
        break_continue.ReplaceContinueWithBreak,
    ],
    'constants': [
        number_replacer.NumberReplacer,
        boolean_replacer.ReplaceTrueWithFalse,
        boolean_replacer.ReplaceFalseWithTrue,
    ],
}


@dataclass(frozen=True)
class Mutant:
    """One change of a file: the ``occurrence``-th place where ``operator`` changes something."""

    file: Path
    kind: str
    operator: Any
    occurrence: int
    line: int  # from 1
    function: str  # the innermost around it, or 'module'
    source: str = field(repr=False)  # as it was when the tests were collected

    def code(self) -> str:
        """Return the text of the mutated file."""
        mutated = mutate_code(self.source, self.operator(), self.occurrence)
        if mutated is None:
            raise RuntimeError(f'{self} changes nothing')
        text: str = mutated
        return text

    def says(self, code: str) -> str:
        """Return the change as the list of equivalents has it: ``function: before ==> after``."""
        before, after = (text.splitlines()[self.line - 1].strip() for text in (self.source, code))
        return f'{self.function}: {before} ==> {after}'


def mutants_of(file: Path) -> list[Mutant]:
    """Return all mutants of a file."""
    source = file.read_text()
    nodes = list(ast_nodes(get_ast(source)))
    found = []
    for kind, operators in KINDS.items():
        for operator in operators:
            places = [
                (node, start) for node in nodes for start, _ in operator().mutation_positions(node)
            ]
            for occurrence, (node, start) in enumerate(places):
                if not _is_described(node):
                    name = ASTQuery(node).get_definition_name() or 'module'
                    found.append(Mutant(file, kind, operator, occurrence, start[0], name, source))
    return found


def _is_described(node: Any) -> bool:
    """Return whether a node is in an annotation or a decorator."""
    while node.parent is not None:
        parent = node.parent
        if parent.type in ('decorator', 'tfpdef'):
            return True
        if parent.type == 'annassign' and node is parent.children[1]:
            return True
        if parent.type == 'funcdef' and node is parent.annotation:
            return True
        node = parent
    return False


def sample(mutants: list[Mutant], count: int, seed: int) -> list[Mutant]:
    """Return a random choice of so many mutants, of the three kinds alike, file by file."""
    chance = random.Random(seed)
    by_kind = [[mutant for mutant in mutants if mutant.kind == kind] for kind in KINDS]
    for each in by_kind:
        chance.shuffle(each)
    turns = itertools.chain.from_iterable(itertools.zip_longest(*by_kind))
    chosen = itertools.islice((mutant for mutant in turns if mutant is not None), count)
    return sorted(chosen, key=lambda mutant: (mutant.file, mutant.line))
