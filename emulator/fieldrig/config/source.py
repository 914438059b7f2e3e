"""The data of a rig: its file, the files that it extends, and overrides from the command line.

`extends: other.yaml` takes the other file first and lays this one over it.  Mappings are merged, and everything else is
replaced, as is a bus or device that gives its `kind` again.  `name: null` removes a bus or device.

`extends: [one.yaml, two.yaml]` joins several files side by side.  None of them takes precedence, so a key to which two
of them give different values is a mistake unless the file that extends them gives the key a value itself.
"""

from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any, Final, TypeVar

from fieldrig.config.yaml_source import KeyPath, Mark, Source, key_text, read, read_file
from fieldrig.errors import Mistake
from fieldrig.text.nearest import closest, nearest_file

T = TypeVar("T")

SORTS: Final = {"buses": "bus", "devices": "device"}
"""The sections of a rig file, and what is in them."""
ENTRY_DEPTH: Final = 2
"""Depth of a bus or device below the top of the file."""
TYPED: Final = "--set "
"""Begins the place of a value that the user has typed."""
_ABSENT: Final = object()
"""The value of a key that a file does not have."""


def gather(path: Path, overrides: Sequence[str]) -> Source:
    """Return everything merged.  It never raises for mistakes in the files."""
    source = _Files().source(path, ())
    if isinstance(source.data, dict):  # else the file has one mistake, and not a further one for each override
        for override in overrides:
            _override(source, override)
    return source


class _Files:
    """The files of one rig.  Each is read once, even if several others extend it."""

    def __init__(self) -> None:
        self._read: dict[Path, Source] = {}

    def source(self, path: Path, extended_by: tuple[Path, ...]) -> Source:
        """Return the file laid over those that it extends."""
        resolved = path.resolve()
        if resolved not in self._read:
            self._read[resolved] = self._laid_over(path, (*extended_by, resolved))
        return self._read[resolved]

    def _laid_over(self, path: Path, extended_by: tuple[Path, ...]) -> Source:
        source = read_file(path)
        if not isinstance(source.data, dict) or "extends" not in source.data:
            return source
        bases = [self.source(base, extended_by) for base in _bases(source, path, extended_by)]
        if not bases:
            return source
        base = bases[0]
        for other in bases[1:]:
            base = _joined(base, other, source)
        return Source(
            data=_over(base.data, source.data, 0),
            marks={**base.marks, **source.marks},
            mistakes=_once([*base.mistakes, *source.mistakes]),
            folders=_once([*source.folders, *base.folders]),
        )


def _bases(source: Source, path: Path, extended_by: tuple[Path, ...]) -> Iterator[Path]:
    """Yield the files in `extends`; those that cannot be extended become mistakes."""
    value = source.data["extends"]
    names = value if isinstance(value, list) else [value]
    if not names or not all(isinstance(name, str) for name in names):
        what, remedy = "it takes a file, or a list of files", "expected extends: other.yaml"
        source.mistakes.append(Mistake(*source.mark(("extends",)), "extends", what, remedy))
        return
    for index, name in enumerate(names):
        place = source.mark(("extends", index))
        file = path.parent / name
        try:
            is_there = file.is_file()
        except OSError as cause:
            source.mistakes.append(Mistake(*place, "extends", f"it cannot be read: {cause.strerror or cause}", ""))
            continue
        if not is_there:
            remedy = nearest_file(file) or "it is relative to this file"
            source.mistakes.append(Mistake(*place, "extends", f"no such file: {file}", remedy))
        elif file.resolve() in extended_by:
            source.mistakes.append(Mistake(*place, "extends", f"{name} extends this file in turn", "take one away"))
        else:
            yield file


def _joined(first: Source, other: Source, over: Source) -> Source:
    """Join two files side by side; where they differ, `over` must have the key."""
    mistakes = over.mistakes
    for path in _differences(first.data, other.data, over.data, ()):
        mark, other_mark = first.mark(path), other.mark(path)
        what = f"{mark.file}:{mark.line} has another value, and {over.mark(()).file} extends both files"
        remedy = f"give the key a value in {over.mark(()).file}, or the same value in both"
        mistakes.append(Mistake(*other_mark, key_text(path), what, remedy))
    return Source(
        data=_beside(first.data, other.data),
        marks={**other.marks, **first.marks},
        mistakes=[*first.mistakes, *other.mistakes],
        folders=[*first.folders, *other.folders],
    )


def _differences(first: Any, other: Any, over: Any, path: KeyPath) -> Iterator[KeyPath]:
    """Yield the keys with different values that remain when `over` is laid over both."""
    if isinstance(first, dict) and isinstance(other, dict):
        for key in [key for key in first if key in other]:
            inner = over.get(key, _ABSENT) if isinstance(over, dict) else _ABSENT
            if inner is _ABSENT or (isinstance(inner, dict) and not _starts_anew(inner, len(path) + 1)):
                yield from _differences(first[key], other[key], inner, (*path, key))
    elif first != other and over is _ABSENT:
        yield path


def _beside(first: Any, other: Any) -> Any:
    """Return both merged; the first wins where they differ."""
    if not isinstance(first, dict) or not isinstance(other, dict):
        return first
    return {**first, **{key: _beside(first[key], value) if key in first else value for key, value in other.items()}}


def _over(base: Any, over: Any, depth: int) -> Any:
    """Return `over` laid over `base`."""
    if not isinstance(base, dict) or not isinstance(over, dict) or _starts_anew(over, depth):
        return over
    merged = dict(base)
    for key, value in over.items():
        if depth == 1 and value is None:
            merged.pop(key, None)
        else:
            merged[key] = _over(base[key], value, depth + 1) if key in base else value
    return merged


def _starts_anew(entry: dict[Any, Any], depth: int) -> bool:
    """Return whether a bus or device replaces the one below it as a whole."""
    return depth == ENTRY_DEPTH and "kind" in entry


def _once(items: Iterable[T]) -> list[T]:
    return list(dict.fromkeys(items))


def _unknown_part(data: Any, path: Sequence[str]) -> tuple[str, str] | None:
    """Return mistake and remedy for a key of a bus or device that the file does not have; None for any other path."""
    if len(path) <= ENTRY_DEPTH or path[0] not in SORTS or path[ENTRY_DEPTH] == "kind" or not isinstance(data, dict):
        return None
    known = data.get(path[0])
    names = [str(name) for name in known] if isinstance(known, dict) else []
    return None if path[1] in names else (f"there is no {SORTS[path[0]]} {path[1]!r}", closest(path[1], names))


def _override(source: Source, override: str) -> None:
    """Apply an override such as `buses.can0.bitrate=250000`: dots between keys, then a YAML value."""
    key, equals, text = override.partition("=")
    place = Mark(f"{TYPED}{override}", None)
    value = read(text, place.file)
    if not equals or value.mistakes:
        remedy = "expected a key and a value, such as buses.can0.bitrate=250000"
        source.mistakes.append(Mistake(*place, "", "it cannot be read as an override", remedy))
        return
    path = tuple(key.split("."))
    if (unknown := _unknown_part(source.data, path)) is not None:
        source.mistakes.append(Mistake(*place, key, *unknown))
        return
    inner: Any = source.data
    for length, part in enumerate(path[:-1], start=1):
        if isinstance(inner, dict) and part not in inner:
            inner[part] = {}
            source.marks[path[:length]] = place
        inner = inner[part] if isinstance(inner, dict) else None
    if isinstance(inner, dict) and value.data is None and len(path) == ENTRY_DEPTH and path[-1] in inner:
        del inner[path[-1]]  # as `name: null` does in a file
    elif isinstance(inner, dict):
        inner[path[-1]] = value.data
        source.marks[path] = place
    else:
        what = f"{'.'.join(path[:-1])} holds no keys"
        source.mistakes.append(Mistake(*place, key, what, "expected a key of the rig file"))
