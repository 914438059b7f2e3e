"""Where the data of a rig comes from: its file, the file that this one extends, and overrides from the command line.

`extends: other.yaml` takes the other file first and lays this one over it.  Mappings are merged, everything else is
replaced; so is a bus or device that names its `kind` anew, and `name: null` takes one away.
"""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from fieldrig.errors import Mistake
from fieldrig.yaml_source import Mark, Source, read


def gather(path: Path, overrides: Sequence[str]) -> Source:
    """Everything laid over each other; never raises for what is wrong in it."""
    source = _file(path, ())
    for override in overrides:
        _override(source, override)
    return source


def _file(path: Path, extended_by: tuple[Path, ...]) -> Source:
    try:
        source = read(path.read_text(encoding="utf-8"), str(path))
        source.folders = [path.absolute().parent]
        source.marks.setdefault((), Mark(str(path), None))
    except (OSError, ValueError) as cause:
        what = "it is not UTF-8 text" if isinstance(cause, ValueError) else cause.strerror or str(cause)
        return Source(mistakes=[Mistake(str(path), None, "", f"it can't be read: {what}", "")])
    if not isinstance(source.data, dict) or "extends" not in source.data:
        return source
    base = _base(source, path, (*extended_by, path.resolve()))
    if base is None:
        return source
    return Source(
        data=_over(base.data, source.data, 0),
        marks={**base.marks, **source.marks},
        mistakes=[*base.mistakes, *source.mistakes],
        folders=[*source.folders, *base.folders],
    )


def _base(source: Source, path: Path, extended_by: tuple[Path, ...]) -> Source | None:
    name = source.data["extends"]
    place = source.marks[("extends",)]
    if not isinstance(name, str):
        source.mistakes.append(Mistake(*place, "extends", "it takes one file", "right would be extends: other.yaml"))
        return None
    file = path.parent / name
    try:
        is_there = file.is_file()
    except OSError as cause:
        source.mistakes.append(Mistake(*place, "extends", f"it can't be read: {cause.strerror or cause}", ""))
        return None
    if not is_there:
        source.mistakes.append(Mistake(*place, "extends", f"no such file: {file}", "it is relative to this file"))
        return None
    if file.resolve() in extended_by:
        source.mistakes.append(Mistake(*place, "extends", f"{name} extends this file in turn", "take one away"))
        return None
    return _file(file, extended_by)


def _over(base: Any, over: Any, depth: int) -> Any:
    """`over` laid over `base`; at depth 2 stand the buses and devices."""
    if not isinstance(base, dict) or not isinstance(over, dict) or (depth == 2 and "kind" in over):
        return over
    merged = dict(base)
    for key, value in over.items():
        if depth == 1 and value is None:
            merged.pop(key, None)
        else:
            merged[key] = _over(base[key], value, depth + 1) if key in base else value
    return merged


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
