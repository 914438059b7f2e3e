"""Files of tools that name the parts of a project, or keep them in a form of their own, instead of being a program.

Each has what to give instead.
"""

from collections.abc import Mapping
from typing import Final

_FOLDER: Final = (
    "Give the folder that it is in: fieldrig takes the .TcPOU, .TcDUT, .TcTLEO, .TcGVL, .TcIO and .TcTTO files there."
)
_EXPORT: Final = "Open it in CODESYS, choose Project, Export PLCopenXML, and give the .xml file."
_EXPORT_V2: Final = "Open it in CoDeSys V2.3, choose Project, Export, and give the .exp file."
_SAID: Final[Mapping[str, tuple[str, str]]] = {
    ".plcproj": ("the list of files of a TwinCAT PLC project", _FOLDER),
    ".tsproj": ("the list of parts of a TwinCAT project", _FOLDER),
    ".tspproj": ("the list of parts of a TwinCAT project", _FOLDER),
    ".sln": ("the list of projects of a solution", _FOLDER),
    ".tmc": ("a description of modules", _FOLDER),
    ".tpzip": ("an archive", "Unpack it, and give the folder."),
    ".tnzip": ("an archive", "Unpack it, and give the folder."),
    ".zip": ("an archive", "Unpack it, and give the folder."),
    ".project": ("a project of CODESYS V3", _EXPORT),
    ".projectarchive": ("an archive of CODESYS V3", _EXPORT),
    ".library": ("a library of CODESYS V3", _EXPORT),
    ".compiled-library": ("a compiled library of CODESYS V3, which has no source text", "Give the library's sources."),
    ".pro": ("a project of CoDeSys V2.3", _EXPORT_V2),
    ".lib": ("a library of CoDeSys V2.3", _EXPORT_V2),
}
"""The nature of a file and what to give instead, by the ending of its name."""


def said_of(name: str) -> tuple[str, str] | None:
    """Return what a file is and what to give instead, by its name; None for a file that may be a program."""
    _, dot, ending = name.rpartition(".")
    return _SAID.get(f"{dot}{ending.lower()}")


CHECKED: Final = 4_096
"""How many characters decide whether a file has no text of programs."""


def is_no_text(text: str) -> bool:
    """True for the text of a solution, and for what is no text at all, such as an archive."""
    head = text[:CHECKED].lstrip("\ufeff\xef\xbb\xbf \t\r\n")
    is_utf_16 = head.startswith(("\xff\xfe", "\xfe\xff"))
    return head.startswith(("PK", "Microsoft Visual Studio")) or ("\0" in head and not is_utf_16)
