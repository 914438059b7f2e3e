"""Questions about this host that the standard library answers by a short process: they are answered in real time.

Libraries ask them where a member does not expect it: trio looks for the library of threads when it starts one.
"""

import ctypes.util
import platform
from collections.abc import Callable
from functools import wraps
from typing import Any

from fieldrig.master_time.active import waiting_scheduler
from fieldrig.master_time.scheduler import Place


def query_swaps() -> list[tuple[Any, Any]]:
    """Return the calls with their stand-ins."""
    queries: tuple[Callable[..., Any], ...] = (ctypes.util.find_library, platform.processor)
    return [(real, _in_real_time(real)) for real in queries]


def _in_real_time(real: Callable[..., Any]) -> Callable[..., Any]:
    """Return a call in which a member sees real time, as a device of the rig does."""

    @wraps(real)
    def query(*args: Any) -> Any:
        scheduler = waiting_scheduler()
        if scheduler is None:
            return real(*args)
        scheduler.place = Place.RIG
        try:
            return real(*args)
        finally:
            scheduler.place = Place.MEMBER

    return query
