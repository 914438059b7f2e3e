"""The source text of the standard function blocks.

The counters and bistables exist twice: CoDeSys names their inputs RESET, LOAD and SET1, edition 3 of the standard
names them R, LD and S1.
"""

from importlib.resources import files

from fieldrig_devices.iec import library

EDITION_3 = "edition-3"
"""Name of the dialect with the standard's own names."""


def sources(dialect: str) -> list[tuple[str, str]]:
    """Return the names and texts of the files for the dialect with this name, in an order that may be compiled."""
    counters = "counters_edition_3.st" if dialect == EDITION_3 else "counters.st"
    names = ["standard.st", counters, "util.st"]
    return [(name, (files(library) / name).read_text(encoding="ascii")) for name in names]
