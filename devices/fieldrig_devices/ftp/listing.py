"""Lists of files: LIST in the form of Unix, NLST, and the facts of MLSD.

Source: RFC 959, 4.1.3; RFC 3659, 7.  The controller keeps no dates, so all files have the same one.
"""

from collections.abc import Mapping, Sequence
from fnmatch import fnmatchcase
from typing import Final

from fieldrig_devices.ftp.files import Files

DATE: Final = "20030101000000"
"""The date of all files, in the form of MDTM (RFC 3659, 2.3): the year of the manual."""
FACTS: Final = ("type", "size", "modify", "perm")
_STEPS: Final = frozenset(("", ".", ".."))
"""The parts of a path that lead to the only folder, as that above it is itself."""


def is_folder(path: str) -> bool:
    """True for a path of the only folder: nothing, `/`, `..`, `./` or `\\.`."""
    return set(path.replace("\\", "/").split("/")) <= _STEPS


def chosen(files: Files, argument: str) -> list[str]:
    """Return the names that a command asks for: all, one, or those of a pattern such as `*.HTM`.

    Options in the manner of `ls`, such as -al, are skipped.  ValueError for a single file that does not exist.
    """
    paths = [word for word in argument.split() if not word.startswith("-")]
    path = " ".join(paths)
    if is_folder(path):
        return files.names
    if set("*?[") & set(path):
        pattern = path.lstrip("/\\").upper()
        return [name for name in files.names if fnmatchcase(name, pattern)]
    name = files.name_of(path)
    files.read(name)
    return [name]


def long_list(files: Files, names: Sequence[str]) -> bytes:
    """Return a LIST in the form of Unix, which clients read."""
    lines = [f"-rw-rw-rw-   1 max4     max4     {len(files.read(name)):>10} Jan 01  2003 {name}\r\n" for name in names]
    return "".join(lines).encode()


def short_list(names: Sequence[str]) -> bytes:
    return "".join(f"{name}\r\n" for name in names).encode()


def facts(files: Files, name: str, wanted: Sequence[str] = FACTS) -> str:
    """Return the facts of a file that are wanted, and its name, as MLSD and MLST give them."""
    known = {"type": "file", "size": str(len(files.read(name))), "modify": DATE, "perm": "adfrw"}
    return _entry(known, wanted, name)


def folder_facts(wanted: Sequence[str] = FACTS) -> str:
    """Return the facts of the only folder."""
    return _entry({"type": "cdir", "perm": "cel"}, wanted, "/")


def fact_list(files: Files, names: Sequence[str], wanted: Sequence[str] = FACTS) -> bytes:
    """Return an MLSD."""
    return "".join(f"{facts(files, name, wanted)}\r\n" for name in names).encode()


def _entry(known: Mapping[str, str], wanted: Sequence[str], name: str) -> str:
    return "".join(f"{fact}={known[fact]};" for fact in wanted if fact in known) + f" {name}"
