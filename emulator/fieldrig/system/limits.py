"""Limits of this process that the system watches over."""

import math
import sys
import time


def limit_busy_seconds(seconds: float) -> None:
    """Have the system end this process, and those that it forks, after this time of a processor.

    It counts whole seconds.  Windows has no such limit.
    """
    if sys.platform != "win32":
        import resource

        soft, (_, hard) = math.ceil(time.process_time() + seconds), resource.getrlimit(resource.RLIMIT_CPU)
        resource.setrlimit(resource.RLIMIT_CPU, (soft if hard == resource.RLIM_INFINITY else min(soft, hard), hard))
