"""Prints the platform that the wheel of an installed package was built for: NAME."""

import sys
from email import message_from_string
from importlib.metadata import distribution


def platform_of(name: str) -> str:
    """Return the platform tag of an installed package, such as manylinux_2_28_x86_64."""
    wheel = message_from_string(distribution(name).read_text('WHEEL'))
    return wheel['Tag'].split('-', 2)[2]


if __name__ == '__main__':
    print(platform_of(sys.argv[1]))
