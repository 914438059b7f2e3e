"""vcdvcd, a foreign reader of VCD files.

When it is imported, it lets a broken pipe end the whole process, which is wrong for a test run.
"""

import signal

_before = signal.getsignal(signal.SIGPIPE)

from vcdvcd import VCDVCD  # noqa: E402, TID251

signal.signal(signal.SIGPIPE, _before)

__all__ = ["VCDVCD"]
