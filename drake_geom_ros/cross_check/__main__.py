"""The process of the second opinion: ``python -m drake_geom_ros.cross_check FD``.

FD is an open end of a pipe. Batches of questions come in, lists of verdicts go out, in order,
until the other side is gone.
"""

import contextlib
import os
import sys
from multiprocessing.connection import Connection

from drake_geom_ros.cross_check.second_opinion import SecondOpinion

NICENESS = 10  # it may wait; the cycles beside may not


def main(descriptor: int) -> None:
    """Serve until the other side is gone."""
    os.nice(NICENESS)
    opinion = SecondOpinion()
    with Connection(descriptor) as connection, contextlib.suppress(EOFError, OSError):
        while True:
            connection.send(opinion.judge(connection.recv()))
    opinion.close()


if __name__ == '__main__':
    main(int(sys.argv[1]))
