"""Answers that are wrong on purpose, and FCL replaced by what dies or hangs."""

import dataclasses
import os


def moved(question, off):
    """Return a question whose distance is off by so much [m]; its witnesses are the right ones."""
    return dataclasses.replace(question, distance=question.distance + off)


class Faulty:
    """Asks FCL but for one pair, over which it dies or hangs; made in the process that it ends."""

    def __init__(self, fcl, ids, fault):
        self._fcl, self._ids, self._fault = fcl, ids, fault

    def __call__(self, query, a, b, *rest):
        if (a, b) == self._ids and self._fault == 'dies':
            os.abort()
        while (a, b) == self._ids:
            pass
        return self._fcl(query, a, b, *rest)
