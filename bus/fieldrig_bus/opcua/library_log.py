"""The log of the library: bytes that a client should not send are dropped without a line, a fault of ours is shown.

The library reports every malformed message as an error with its traceback, so one client could fill the disk.
"""

import logging
from types import TracebackType
from typing import Final

_SERVER: Final = ("asyncua.server.uaprocessor", "asyncua.server.binary_server_asyncio")
"""The loggers of the library for messages of clients."""


def quieten() -> None:
    """Log only warnings of the library, and of messages of clients only what has failed in our code."""
    logging.getLogger("asyncua").setLevel(logging.WARNING)  # it reports every request otherwise
    for name in _SERVER:
        logger = logging.getLogger(name)
        if is_ours not in logger.filters:
            logger.addFilter(is_ours)


def is_ours(record: logging.LogRecord) -> bool:
    """True for a message about an exception that has passed through our code."""
    trace: TracebackType | None = record.exc_info[2] if record.exc_info else None
    while trace is not None:
        if str(trace.tb_frame.f_globals.get("__name__", "")).startswith("fieldrig"):
            return True
        trace = trace.tb_next
    return False
