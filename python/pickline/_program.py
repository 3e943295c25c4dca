"""The command ``pickline``, which is the same program as the one that cargo builds."""

import signal
import sys

from pickline._pickline import program


def main() -> int:
    """Run the program with the arguments of this process and return its exit code."""
    # Ctrl-C ends the program, or stops its work with the best result so far; Python's own handler would
    # only run after the program has ended.
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, signal.SIG_DFL)
    return program(["pickline", *sys.argv[1:]])


if __name__ == "__main__":
    sys.exit(main())
