"""The library for MF4 files (ASAM MDF 4), which the extra `mf4` installs."""

import logging
from typing import Any, Final

from fieldrig.errors import UsageError

INSTALL: Final = "pip install 'fieldrig[mf4]'"


def asammdf() -> Any:
    """Return the library, which takes half a second to import.  UsageError, with the extra, where it is missing."""
    try:
        import asammdf
    except ImportError as missing:
        raise UsageError(f"MF4 needs the package {missing.name or 'asammdf'}", INSTALL) from missing
    logging.getLogger("asammdf").setLevel(logging.CRITICAL)  # it says there what it raises
    return asammdf
