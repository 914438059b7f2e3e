"""The search for circular garbage, for compilers, which make many objects at once.

Python's own search looks through all that a compiler has made again and again, which takes a third of its time.  But
the trees and tables that a compiler leaves refer to each other in circles, so they have to be searched for some time.
"""

import gc
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Final

MOST_LEFT: Final = 200_000
"""Objects that compilations may leave until they are searched for: about 40 MB."""


class GarbageCollection:
    def __init__(self) -> None:
        self._left = 0
        """Objects that have been left since the last search."""

    @contextmanager
    def paused(self) -> Iterator[None]:
        """Search for nothing in the meantime, and for everything at the end if that is due."""
        if not gc.isenabled():  # within another pause, or in a process that ends with its work
            yield
            return
        before = gc.get_count()[0]
        gc.disable()
        try:
            yield
        finally:
            gc.enable()
            self._left += gc.get_count()[0] - before
            if self._left >= MOST_LEFT:
                self._left = 0
                gc.collect()


collection: Final = GarbageCollection()
"""The one of this process, for all of its compilers."""
