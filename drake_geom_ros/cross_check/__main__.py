"""Process of the second opinion: ``python -m drake_geom_ros.cross_check FD``.

FD is an open end of a pipe. The process receives batches of questions and sends lists of
verdicts, in order, until the other end is closed.
"""

import contextlib
import os
import sys
from multiprocessing.connection import Connection

from drake_geom_ros.cross_check.second_opinion import SecondOpinion

NICENESS = 10  # lower priority than the node's cycles


def main(descriptor: int) -> None:
    """Serve until the other end of the pipe is closed."""
    os.nice(NICENESS)
    opinion = SecondOpinion()
    with Connection(descriptor) as connection, contextlib.suppress(EOFError, OSError):
        while True:
            connection.send(opinion.judge(connection.recv()))
    opinion.close()


if __name__ == '__main__':
    main(int(sys.argv[1]))
