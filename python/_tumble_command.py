"""The command `tumble` of the package: the C++ program itself takes the place of this process."""

import os
import sys


def main() -> None:
    """Runs the program with the arguments of this process."""
    program = os.path.join(os.path.dirname(os.path.abspath(__file__)), "tumble", "bin", "tumble")
    os.environ.setdefault("TUMBLE_PYTHON", sys.executable)  # for the verbs that Python carries out
    os.execv(program, ["tumble", *sys.argv[1:]])
