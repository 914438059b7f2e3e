"""The source text of the standard function blocks and of functions with several results, and the trees of libraries.

The counters and bistables exist twice: CoDeSys names their inputs RESET, LOAD and SET1, edition 3 of the standard names
them R, LD and S1. Edition 3 also has counters for larger types: CTU_DINT and so on, and functions for the parts of
dates. Timers for LTIME are LTON and so on in CODESYS, and TON_LTIME and so on in edition 3, which has TON_TIME as well.
For programs of TwinCAT there is a part of its libraries.
"""

import re
from functools import cache
from importlib.resources import files
from typing import Final

from fieldrig_devices.iec import library
from fieldrig_devices.iec.dialect import Dialect
from fieldrig_devices.iec.elementary import Elementary
from fieldrig_devices.iec.parser import parse
from fieldrig_devices.iec.tree import TypeDeclaration, Unit, Variables
from fieldrig_devices.languages.mistakes import CompileError

EDITION_3: Final = "edition-3"
"""Name of the dialect with the standard's own names."""
CODESYS: Final = "codesys"
"""Name of the dialect with what programs of TwinCAT expect."""
LISTS: Final = {"_TaskInfo": "TwinCAT_SystemInfoVarList", "TcEvents_happened": "Tc3_EventLogger_List"}
"""The names of lists of global variables in our libraries, by their first variable."""
_OF_CODESYS: Final = (
    "system.st",
    "twincat.st",
    "twincat_ads.st",
    "twincat_control.st",
    "twincat_events.st",
    "twincat_mc2.st",
    "twincat_tables.st",
)
LARGE: Final = (Elementary.DINT, Elementary.UDINT, Elementary.LINT, Elementary.ULINT)
"""The types that edition 3 has further counters for."""


@cache
def sources(dialect: str) -> tuple[tuple[str, str], ...]:
    """Return the names and texts of the files for the dialect with this name."""
    names = ("standard.st", "counters.st", "util.st")
    if dialect == CODESYS:
        texts = [(name, _without_first_edge(_text(name))) for name in (*names, *_OF_CODESYS)]
        return (*texts, ("timers_ltime.st", _timers(r"L\1", Elementary.LTIME)))
    if dialect != EDITION_3:
        return tuple((name, _text(name)) for name in names)
    counters = _text("counters_edition_3.st")
    large = tuple((f"counters_{kind.name.lower()}.st", _counters_of(kind, counters)) for kind in LARGE)
    others = tuple((name, _text(name)) for name in ("standard.st", "dates_edition_3.st", "util.st"))
    others = (*others, ("dates_ldate.st", _long_dates(_text("dates_edition_3.st"))))
    kinds = (Elementary.TIME, Elementary.LTIME)
    timers = tuple((f"timers_{kind.name.lower()}.st", _timers(rf"\1_{kind.name}", kind)) for kind in kinds)
    return (*others, ("counters.st", counters), *large, *timers)


@cache
def types_of(dialect: Dialect) -> frozenset[str]:
    """Return the names of the types in our libraries, in small letters."""
    units = [parsed(text, name, dialect) for name, text in sources(dialect.name)]
    return frozenset(
        one.name.casefold() for unit in units for one in unit.declarations if isinstance(one, TypeDeclaration)
    )


@cache
def parsed(text: str, name: str, dialect: Dialect) -> Unit:
    """Return the tree of a library, parsed once in a process; CompileError for mistakes, which are ours."""
    unit, mistakes = parse(text, name, dialect)
    if mistakes:
        raise CompileError(mistakes)
    for declared in unit.declarations:
        if isinstance(declared, Variables):
            declared.name = LISTS.get(declared.variables[0].name, "")
    return unit


def _text(name: str) -> str:
    return (files(library) / name).read_text(encoding="ascii")


def _without_first_edge(text: str) -> str:
    """Return a text whose F_TRIG finds no edge in its first call, as that of CODESYS and TwinCAT.

    Source: the help of CODESYS about SF_F_TRIG, which says how it differs from F_TRIG of its library Standard.
    """
    return text.replace("    M : BOOL;\nEND_VAR\nQ := NOT CLK", "    M : BOOL := TRUE;\nEND_VAR\nQ := NOT CLK")


def _timers(name: str, kind: Elementary) -> str:
    """The timers for TIME or LTIME, whose names `name` makes of TON, TOF and TP."""
    text, pattern = _text("standard.st"), r"^FUNCTION_BLOCK T\w+\n.*?^END_FUNCTION_BLOCK\n"
    joined = "\n".join(re.findall(pattern, text, re.MULTILINE | re.DOTALL))
    for begin, end in ((": ", ";"), ("", "()")):
        joined = joined.replace(f"{begin}TIME{end}", f"{begin}{kind.name}{end}")
    joined = joined.replace("T#", f"{kind.name}#")
    return re.sub(r"^FUNCTION_BLOCK (T\w+)", rf"FUNCTION_BLOCK {name}", joined, flags=re.MULTILINE)


def _long_dates(text: str) -> str:
    """The functions for the parts of LDATE, LTOD and LDT, which count nanoseconds; DAY_OF_WEEK has DATE only."""
    long = re.sub(r"\b(DATE|TOD|DT)\b|(?<=_)(DATE|TOD|DT)\b|\b(DATE|TOD|DT)(?=_TO_)", r"L\1\2\3", text)
    long = long.replace("86400", "86400000000000").replace("MILLISECOND) * 1)", "MILLISECOND) * 1000000)")
    long = long.replace("TOD_TO_LINT(IN) / 1;", "TOD_TO_LINT(IN) / 1000000;").replace(
        "MILLISECOND)) / 1000)", "MILLISECOND)))"
    )
    return re.sub(r"\(\* 0 is Sunday.*", "", long, flags=re.DOTALL)


def _counters_of(kind: Elementary, text: str) -> str:
    """The counters of the text, which count in INT, for another type."""
    blocks = re.findall(r"^FUNCTION_BLOCK CT.*?^END_FUNCTION_BLOCK\n", text, re.MULTILINE | re.DOTALL)
    joined = "\n".join(blocks).replace(": INT;", f": {kind.name};").replace(str(Elementary.INT.high), str(kind.high))
    return re.sub(r"^FUNCTION_BLOCK (CT\w+)", rf"FUNCTION_BLOCK \1_{kind.name}", joined, flags=re.MULTILINE)
