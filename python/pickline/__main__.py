"""``python -m pickline`` runs the program."""

import sys

from pickline._program import main

sys.exit(main())
