"""The time for which a test waits, in real time, for what must happen."""

from typing import Final

PATIENCE_S: Final = 300.0
"""It ends a test that hangs, and is no promise of anybody: a host that does ten times too much is late by a minute."""
