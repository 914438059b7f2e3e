"""A source file of a project: its name and its text, and the files that it includes."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path


@dataclass(frozen=True, slots=True)
class SourceFile:
    name: str
    text: str
    path: Path | None = field(default=None, compare=False)
    """The file itself, if its name is only a part of its path."""


def found_beside(folder: Path, name: str) -> Path | None:
    r"""Return the file that a program includes by the name that its system had for it, or None.

    The name is relative to `folder`, has / or \\ between its parts, and its letters may be of another case; a file with
    its very spelling comes first.  Nothing outside of the folder is found.
    """
    parts = _inside(name)
    candidates = [folder.resolve()] if parts else []
    for part in parts:
        candidates = [path for candidate in candidates for path in _called(candidate, part)]
    return next((path for path in candidates if path.is_file() and _is_within(path, folder)), None)


def _inside(name: str) -> Sequence[str]:
    """Return the parts of a path below a folder; none for a path that leads out of it."""
    names: list[str] = []
    for part in name.replace("\\", "/").split("/"):
        if part == ".." and not names:
            return ()
        if part == "..":
            names.pop()
        elif part not in ("", "."):
            names.append(part)
    return () if name[:1] in ("/", "\\") else names


def _called(folder: Path, name: str) -> Iterator[Path]:
    """Yield what a folder has under a name, the same spelling first."""
    try:
        entries = sorted(folder.iterdir(), key=lambda path: (path.name != name, path.name))
    except OSError:  # no folder, or one that may not be read
        return
    yield from (path for path in entries if path.name.casefold() == name.casefold())


def _is_within(path: Path, folder: Path) -> bool:
    """False for a link that leads out of the folder."""
    return path.resolve().is_relative_to(folder.resolve())
