"""Where the data of a rig comes from: its file, the files that this one extends, and overrides from the command line.

`extends: other.yaml` takes the other file first and lays this one over it.  Mappings are merged, everything else is
replaced; so is a bus or device that names its `kind` anew, and `name: null` takes one away.

`extends: [one.yaml, two.yaml]` joins several files side by side: none of them has precedence, so a key to which two of
them give different values is a mistake unless the file that extends them gives that key a value itself.
"""

from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any, Final, TypeVar

from fieldrig.errors import Mistake
from fieldrig.yaml_source import KeyPath, Mark, Source, key_text, read, read_file

T = TypeVar("T")

ENTRY_DEPTH: Final = 2
"""Of a bus or device below the top of the file."""
_ABSENT: Final = object()
"""What a file has at a key that it doesn't mention."""


def gather(path: Path, overrides: Sequence[str]) -> Source:
    """Everything laid over each other; never raises for what is wrong in it."""
    source = _Files().source(path, ())
    for override in overrides:
        _override(source, override)
    return source


class _Files:
    """The files that one rig is made of.  Each is read once, even if several others extend it."""

    def __init__(self) -> None:
        self._read: dict[Path, Source] = {}

    def source(self, path: Path, extended_by: tuple[Path, ...]) -> Source:
        """The file laid over those that it extends."""
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
    """The files that `extends` names; those that can't be extended become mistakes."""
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
            source.mistakes.append(Mistake(*place, "extends", f"it can't be read: {cause.strerror or cause}", ""))
            continue
        if not is_there:
            source.mistakes.append(Mistake(*place, "extends", f"no such file: {file}", "it is relative to this file"))
        elif file.resolve() in extended_by:
            source.mistakes.append(Mistake(*place, "extends", f"{name} extends this file in turn", "take one away"))
        else:
            yield file


def _joined(one: Source, other: Source, over: Source) -> Source:
    """Two files side by side; where they differ, `over` has to give the key a value."""
    mistakes = over.mistakes
    for path in _differences(one.data, other.data, over.data, ()):
        first, second = one.mark(path), other.mark(path)
        what = f"{first.file}:{first.line} has another value, and {over.mark(()).file} extends both files"
        remedy = f"give the key a value in {over.mark(()).file}, or the same value in both"
        mistakes.append(Mistake(*second, key_text(path), what, remedy))
    return Source(
        data=_beside(one.data, other.data),
        marks={**other.marks, **one.marks},
        mistakes=[*one.mistakes, *other.mistakes],
        folders=[*one.folders, *other.folders],
    )


def _differences(one: Any, other: Any, over: Any, path: KeyPath) -> Iterator[KeyPath]:
    """Keys with different values of which nothing is left once `over` is laid over them."""
    if isinstance(one, dict) and isinstance(other, dict):
        for key in [key for key in one if key in other]:
            inner = over.get(key, _ABSENT) if isinstance(over, dict) else _ABSENT
            if inner is _ABSENT or (isinstance(inner, dict) and not _starts_anew(inner, len(path) + 1)):
                yield from _differences(one[key], other[key], inner, (*path, key))
    elif one != other and over is _ABSENT:
        yield path


def _beside(one: Any, other: Any) -> Any:
    """Both, merged; the first has what differs."""
    if not isinstance(one, dict) or not isinstance(other, dict):
        return one
    return {**one, **{key: _beside(one[key], value) if key in one else value for key, value in other.items()}}


def _over(base: Any, over: Any, depth: int) -> Any:
    """`over` laid over `base`."""
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
    """Whether this is a bus or device that replaces the one below it as a whole."""
    return depth == ENTRY_DEPTH and "kind" in entry


def _once(items: Iterable[T]) -> list[T]:
    return list(dict.fromkeys(items))


def _override(source: Source, override: str) -> None:
    """`buses.can0.bitrate=250000`: dots between keys, then a YAML value."""
    key, equals, text = override.partition("=")
    place = Mark(f"--set {override}", None)
    value = read(text, place.file)
    if not equals or value.mistakes:
        right = "right would be a key and a value, like buses.can0.bitrate=250000"
        source.mistakes.append(Mistake(*place, "", "it can't be understood", right))
        return
    path = tuple(key.split("."))
    inner = source.data
    for length, part in enumerate(path[:-1], start=1):
        if isinstance(inner, dict) and part not in inner:
            inner[part] = {}
            source.marks[path[:length]] = place
        inner = inner[part] if isinstance(inner, dict) else None
    if isinstance(inner, dict):
        inner[path[-1]] = value.data
        source.marks[path] = place
    else:
        what = f"{'.'.join(path[:-1]) or 'the file'} holds no keys"
        source.mistakes.append(Mistake(*place, key, what, "right would be a key of the rig file"))
