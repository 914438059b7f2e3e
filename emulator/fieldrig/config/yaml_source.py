"""A YAML file as plain Python values, with the line of every key.

YAML 1.2: 010 is ten, `on` and 12:30 are text; dates stay text too.  Merge keys (`<<`) are known; tags are refused, and
keys that are neither text nor whole numbers.  Values are made from ruamel's node graph here: its own constructors stop
at the first duplicate key, and give values that are not plain Python.

A device's file, such as a register table or a name plate, is loaded by `settings_file.load_settings`, which reads it
here, checks it against a model, and collects every mistake.  `source.py` reads rig files, which may extend others.
Nothing else reads YAML.
"""

import warnings
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path
from typing import Any, NamedTuple

from ruamel.yaml import YAML
from ruamel.yaml.error import MarkedYAMLError, ReusedAnchorWarning, YAMLError
from ruamel.yaml.nodes import MappingNode, ScalarNode, SequenceNode

from fieldrig.errors import Mistake
from fieldrig.text.nearest import nearest_file

KeyPath = tuple[Any, ...]

TAG = "tag:yaml.org,2002:"
MERGE = TAG + "merge"
TEXTS = {TAG + name for name in ("str", "timestamp", "value")}
BASES = {"0x": 16, "0o": 8, "0b": 2}
CONTAINERS = {TAG + "map", TAG + "seq"}
LONGEST_KEPT = 16_384
"""Characters of the longest text whose tree is kept: ten drives have one name plate, and reading it takes 10 ms."""

LONGEST_INT = 100
"""Digits of the longest integer; Python refuses to print ints of 4300 digits."""

LARGEST = 100_000
"""Most nodes after aliases are followed.  A longer text may have a node for each of its characters, such as a table of
all 65,536 registers; more is a mistake, or malicious."""


class Mark(NamedTuple):
    """The place of a key."""

    file: str
    line: int | None


NOWHERE = Mark("", None)


@dataclass
class Source:
    """The content of a file: `data` without places, and the places by key path."""

    data: Any = None
    marks: dict[KeyPath, Mark] = field(default_factory=dict)
    mistakes: list[Mistake] = field(default_factory=list)
    folders: list[Path] = field(default_factory=list)
    """The folders of the files that the data names: that of this file, and those of files that it extends."""

    def mark(self, path: KeyPath) -> Mark:
        """Return the place of a key, or of the nearest key above it if it is missing."""
        data, length = self.data, 0
        for part in path:
            if not _has(data, part):
                break
            data, length = data[part], length + 1
        while length and path[:length] not in self.marks:
            length -= 1
        return self.marks.get(path[:length], NOWHERE)


def read(text: str, file: str) -> Source:
    """Read a text.  It never raises for its content; see `mistakes`."""
    source = Source()
    try:
        node = _compose(text)
        if node is not None:
            source.marks[()] = Mark(file, node.start_mark.line + 1)
            source.data = _Reader(source, file, max(LARGEST, len(text))).value(node, ())
    except MarkedYAMLError as broken:
        mark = broken.problem_mark or broken.context_mark
        what = ", ".join(part for part in (broken.context, broken.problem) if part)
        source.mistakes.append(_not_yaml(file, mark.line + 1 if mark else None, what))
    except YAMLError as broken:
        source.mistakes.append(_not_yaml(file, None, " ".join(str(broken).split())))
    except RecursionError:
        source.mistakes.append(_not_yaml(file, None, "it is nested too deeply"))
    return source


def read_file(path: Path) -> Source:
    """Read a file.  It never raises: a file that cannot be read, or is not UTF-8, is one of its `mistakes`."""
    try:
        source = read(path.read_text(encoding="utf-8"), str(path))
    except (OSError, ValueError) as cause:
        what = "it is not UTF-8 text" if isinstance(cause, ValueError) else cause.strerror or str(cause)
        if isinstance(cause, IsADirectoryError):
            return Source(mistakes=[Mistake(str(path), None, "", "it is a folder, not a file", _rig_files(path))])
        return Source(mistakes=[Mistake(str(path), None, "", f"it cannot be read: {what}", nearest_file(path))])
    source.folders = [path.absolute().parent]
    source.marks.setdefault((), Mark(str(path), None))
    return source


def _rig_files(folder: Path) -> str:
    try:
        names = sorted(file.name for file in folder.glob("*.yaml"))
    except OSError:
        return ""
    return f"name files in it, such as {folder / names[0]}" if names else ""


def _compose(text: str) -> Any:
    """Return the tree of a text, which is only read."""
    return _kept_tree(text) if len(text) <= LONGEST_KEPT else _tree(text)


@lru_cache(maxsize=16)
def _kept_tree(text: str) -> Any:
    return _tree(text)


def _tree(text: str) -> Any:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ReusedAnchorWarning)
        try:
            return YAML(typ="safe", pure=True).compose(text)
        except (ArithmeticError, AssertionError, AttributeError, LookupError, NotImplementedError, ValueError) as cause:
            raise YAMLError(f"{cause}") from cause  # escapes and directives that ruamel doesn't check


def _has(data: Any, part: Any) -> bool:
    if isinstance(data, dict):
        return part in data
    return isinstance(data, list) and isinstance(part, int) and part < len(data)


def key_text(path: KeyPath) -> str:
    """Return a path as text, such as `devices.io.signals[2].wire`."""
    text = ""
    for part in path:
        text += f"[{part}]" if isinstance(part, int) else f".{part}"
    return text.removeprefix(".")


def _not_yaml(file: str, line: int | None, what: str) -> Mistake:
    return Mistake(file, line, "", f"this is not YAML: {what}", "look at the indentation, colons and quotes here")


class _Reader:
    """One pass over the node graph of one file."""

    def __init__(self, source: Source, file: str, most_nodes: int) -> None:
        self._source, self._file, self._most_nodes = source, file, most_nodes
        self._nodes = 0
        self._open: set[int] = set()

    def value(self, node: Any, path: KeyPath) -> Any:
        self._nodes += 1
        if self._nodes > self._most_nodes:
            raise YAMLError(f"its aliases stand for more than {self._most_nodes} values")
        if isinstance(node, ScalarNode):
            return self._scalar(node, path)
        if id(node) in self._open:
            raise MarkedYAMLError(problem="a value that contains itself", problem_mark=node.start_mark)
        if node.tag not in CONTAINERS:
            self._refuse_tag(node, path)
        self._open.add(id(node))
        value = self._mapping(node, path) if isinstance(node, MappingNode) else self._sequence(node, path)
        self._open.discard(id(node))
        return value

    def _sequence(self, node: SequenceNode, path: KeyPath) -> list[Any]:
        items = []
        for index, item in enumerate(node.value):
            here = (*path, index)
            self._source.marks[here] = self._mark(item)
            items.append(self.value(item, here))
        return items

    def _mapping(self, node: MappingNode, path: KeyPath) -> dict[Any, Any]:
        merged: dict[Any, Any] = {}
        for key_node, value_node in node.value:
            if key_node.tag == MERGE:
                self._merge(merged, value_node, path)
        own: dict[Any, Any] = {}
        for key_node, value_node in node.value:
            if key_node.tag == MERGE:
                continue
            key = self.value(key_node, path)
            here = (*path, key)
            if type(key) not in (str, int):
                self._mistake(key_node, path, "a key is a name or a whole number", "expected quotes around it")
            elif key in own:
                first = self._source.marks[here].line
                self._mistake(key_node, here, f"the same key is in line {first}", "keep one of the two")
            else:
                self._source.marks[here] = self._mark(key_node)
                own[key] = self.value(value_node, here)
        return {**merged, **own}

    def _merge(self, merged: dict[Any, Any], node: Any, path: KeyPath) -> None:
        """Apply a YAML merge key: earlier mappings win over later ones, and own keys win over all."""
        for mapping in reversed(node.value) if isinstance(node, SequenceNode) else [node]:
            if isinstance(mapping, MappingNode):
                merged.update(self.value(mapping, path))
            else:
                self._mistake(mapping, path, "<< takes a mapping", "expected `<<: *name` with an anchored mapping")

    def _scalar(self, node: ScalarNode, path: KeyPath) -> Any:
        tag, text = node.tag, node.value
        if tag == TAG + "int":
            return _int(text)
        if tag == TAG + "float":
            return _float(text)
        if tag == TAG + "bool":
            return text.lower() == "true"
        if tag == TAG + "null":
            return None
        if tag not in TEXTS:
            self._refuse_tag(node, path)
        return self._text(node, path)

    def _text(self, node: ScalarNode, path: KeyPath) -> str:
        """Return the text; escapes can name code points that are not characters."""
        text: str = node.value
        try:
            text.encode()
        except UnicodeEncodeError:
            self._mistake(node, path, "half of a surrogate pair is not a character", "expected \\U and 8 digits")
            return text.encode(errors="replace").decode()
        return text

    def _refuse_tag(self, node: Any, path: KeyPath) -> None:
        self._mistake(node, path, f"the tag {node.tag} has no meaning here", "take it away")

    def _mark(self, node: Any) -> Mark:
        return Mark(self._file, node.start_mark.line + 1)

    def _mistake(self, node: Any, path: KeyPath, what: str, remedy: str) -> None:
        self._source.mistakes.append(Mistake(*self._mark(node), key_text(path), what, remedy))


def _int(text: str) -> int | str:
    """Return an integer, decimal unless 0x, 0o or 0b; anything that only looks like a number stays text."""
    digits = text.replace("_", "").lower()
    unsigned = digits.lstrip("+-")
    try:
        return int(digits, BASES.get(unsigned[:2], 10)) if len(digits) <= LONGEST_INT else text
    except ValueError:
        return text


def _float(text: str) -> float | str:
    try:
        return float(text.lower().replace("_", "").replace(".inf", "inf").replace(".nan", "nan"))
    except ValueError:
        return text
