"""The exit codes of all commands, for scripts that decide by them."""

DONE = 0
NO = 1  # what was checked does not hold, or the answer has reservations
BAD_INPUT = 2  # arguments or files, reported in one line on standard error; as of argparse
NOT_PROVED = 3  # `check-motion`: clear in pieces only; `report --audit`: a node is refuted
NEARER = 4  # `report --compare`: nearer than the other run
UNFORESEEN = 70  # an internal error, with its traceback; as in sysexits.h
INTERRUPTED = 130  # as shells report SIGINT
READER_LEFT = 141  # as shells report SIGPIPE
