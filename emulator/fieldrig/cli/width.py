"""The width of what the commands print."""

import shutil
import sys
from typing import Final

PIPE_WIDTH: Final = 100
"""Width of a line, in characters, where the output is not a terminal."""


def output_width() -> int:
    """Return the width of the terminal in characters, or that of a line elsewhere."""
    return shutil.get_terminal_size((PIPE_WIDTH, 24)).columns if sys.stdout.isatty() else PIPE_WIDTH
