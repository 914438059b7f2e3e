"""The library for MF4 files (ASAM MDF 4), which the extra `mf4` installs."""

import logging
from typing import Any, Final

from fieldrig.clock import S
from fieldrig.errors import UsageError

LINEAR: Final = 1
"""The type of a conversion by a factor and an offset."""
INSTALL: Final = "pip install 'fieldrig[mf4]'"


def asammdf() -> Any:
    """Return the library, which takes half a second to import.  UsageError, with the extra, where it is missing."""
    try:
        import asammdf
    except ImportError as missing:
        raise UsageError(f"MF4 needs the package {missing.name or 'asammdf'}", INSTALL) from missing
    logging.getLogger("asammdf").setLevel(logging.CRITICAL)  # it says there what it raises
    return asammdf


def count_nanoseconds(mdf: Any, group: int) -> None:
    """Let the times of a new group be whole nanoseconds, with a factor that makes seconds of them."""
    from asammdf.blocks.v4_blocks import ChannelConversion

    master = mdf.groups[group].channels[mdf.masters_db[group]]
    master.conversion = ChannelConversion(conversion_type=LINEAR, a=1 / S, b=0.0)
