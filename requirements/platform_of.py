"""Prints the platform that the wheel of an installed package was built for: NAME."""

import sys
from email import message_from_string
from importlib.metadata import distribution

wheel = message_from_string(distribution(sys.argv[1]).read_text('WHEEL'))
print(wheel['Tag'].split('-', 2)[2])
