"""The trees of the libraries, each parsed once in a process."""

from functools import cache

from fieldrig_devices.iec.dialect import Dialect
from fieldrig_devices.iec.parser import parse
from fieldrig_devices.iec.tree import Unit
from fieldrig_devices.languages.mistakes import CompileError


@cache
def parsed(text: str, name: str, dialect: Dialect) -> Unit:
    """Return the tree of a library; CompileError if it has mistakes, because a library is ours."""
    unit, mistakes = parse(text, name, dialect)
    if mistakes:
        raise CompileError(mistakes)
    return unit
