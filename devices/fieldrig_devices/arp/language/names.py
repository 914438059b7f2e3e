"""Resolve the names of an ARP program: EQU names, labels and routines.

Source: manual 5, 5.1, 5.5; digest chapter 3.  All names are unique in the whole source.  An EQU may appear anywhere,
applies everywhere, and may refer to another EQU; repeating the same EQU defines one symbol, as in the manual's own
example.
"""

import dataclasses
from collections.abc import Iterator
from dataclasses import dataclass, field
from difflib import get_close_matches
from typing import Any, Final, TypeVar

from fieldrig_devices.arp.language import instructions
from fieldrig_devices.arp.language.tree import (
    Direct,
    Equ,
    Indexed,
    Line,
    Name,
    Node,
    Number,
    Program,
    Resource,
    Routine,
)
from fieldrig_devices.languages.mistakes import Mistake

_N = TypeVar("_N", bound=Node)
_LEVELS: Final = {"HIGH": "HI", "TRUE": "HI", "YES": "HI", "LOW": "LO", "FALSE": "LO", "NO": "LO"}
_LOOKS_LIKE = str.maketrans("IO", "10")  # the manual's own misprints: VI for V1


@dataclass
class Symbols:
    equs: dict[str, Resource | Number] = field(default_factory=dict)
    """Meaning of each EQU name, with the names in it resolved."""
    labels: dict[str, str] = field(default_factory=dict)
    """Name of the routine that contains each label."""
    routines: dict[str, Routine] = field(default_factory=dict)


def resolve(program: Program) -> tuple[Program, Symbols, list[Mistake]]:
    """Replace all names apart from labels and routines.  A line with an unknown name loses its content."""
    resolver = _Resolver(program)
    return resolver.program(), resolver.symbols, resolver.mistakes


class _Unknown(Exception):  # noqa: N818  never leaves this file
    def __init__(self, name: Name, what: str, expected: str = "") -> None:
        super().__init__(what)
        self.name, self.what, self.expected = name, what, expected


class _Resolver:
    def __init__(self, program: Program) -> None:
        self._program = program
        self.symbols = Symbols()
        self.mistakes: list[Mistake] = []
        self._lines: dict[str, int] = {}
        self._raw: dict[str, Resource | Number] = {}
        for routine in program.routines:
            if self._define(routine.name, routine.number, 1):
                self.symbols.routines[routine.name] = routine
        for line in program.outside:
            self._define_line(line, "")
        for routine in program.routines:
            for line in routine.lines:
                self._define_line(line, routine.name)
        for name, meaning in self._raw.items():
            self._define_equ(name, meaning)

    def program(self) -> Program:
        routines = tuple(
            dataclasses.replace(routine, lines=tuple(self._resolved_lines(routine)))
            for routine in self._program.routines
        )
        return Program(routines)

    def _define(self, name: str, line: int, column: int) -> bool:
        if name in self._lines:
            self._say(line, column, f"{name} is already defined in line {self._lines[name]}", "another name")
            return False
        self._lines[name] = line
        return True

    def _define_line(self, line: Line, routine: str) -> None:
        if line.label is not None and self._define(line.label, line.number, line.label_column):
            self.symbols.labels[line.label] = routine
        if isinstance(line.content, Equ):
            equ = line.content
            if self._raw.get(equ.name) == equ.meaning:
                what = f"{equ.name} is already in line {self._lines[equ.name]}"
                self.mistakes.append(Mistake(line.number, equ.column, what, is_note=True))
            elif self._define(equ.name, line.number, equ.column):
                self._raw[equ.name] = equ.meaning

    def _define_equ(self, name: str, meaning: Resource | Number) -> None:
        try:
            self.symbols.equs[name] = self._meaning(meaning, (name,))
        except _Unknown as unknown:
            self._say(self._lines[name], unknown.name.column, unknown.what, unknown.expected)

    def _meaning(self, meaning: Resource | Number, path: tuple[str, ...]) -> Resource | Number:
        if isinstance(meaning, Name):
            if meaning.text in path:
                raise _Unknown(meaning, f"{' is '.join([*path, meaning.text])}: the definition is circular")
            if meaning.text not in self._raw:
                raise self._unknown(meaning)
            return self._meaning(self._raw[meaning.text], (*path, meaning.text))
        if isinstance(meaning, Indexed) and isinstance(meaning.index, Name):
            return self._indexed(meaning, self._meaning(meaning.index, path))
        return meaning

    def _indexed(self, resource: Indexed, index: object) -> Direct | Indexed:
        if isinstance(index, Direct) and index.letter == "V":
            return Indexed(resource.letter, index, column=resource.column)
        if isinstance(index, Number) and index.raw % 1000 == 0 and not index.is_hex:
            return Direct(resource.letter, index.raw // 1000, column=resource.column)
        assert isinstance(resource.index, Name)
        raise _Unknown(
            resource.index, f"{resource.index.text} cannot be an index", "a name for a variable V or a whole number"
        )

    def _resolved_lines(self, routine: Routine) -> Iterator[Line]:
        for line in routine.lines:
            content = line.content
            if content is not None and not isinstance(content, Equ):
                try:
                    yield dataclasses.replace(line, content=self._resolved(content))
                    continue
                except _Unknown as unknown:
                    self._say(line.number, unknown.name.column, unknown.what, unknown.expected)
            if line.label is not None:
                yield dataclasses.replace(line, content=None)

    def _resolved(self, node: _N) -> _N:
        """Replace every Name in the node by its meaning, at the column of the name."""
        changes: dict[str, Any] = {}
        for part in dataclasses.fields(node):
            value = getattr(node, part.name)
            if isinstance(value, Node):
                changes[part.name] = self._replacement(value)
            elif isinstance(value, tuple):
                changes[part.name] = tuple(self._replacement(element) for element in value)
        return dataclasses.replace(node, **changes) if changes else node

    def _replacement(self, node: Node) -> Node:
        if isinstance(node, Name):
            meaning = self.symbols.equs.get(node.text)
            if meaning is None:
                raise self._unknown(node)
            return dataclasses.replace(meaning, column=node.column)
        if isinstance(node, Indexed) and isinstance(node.index, Name):
            return self._indexed(node, self._replacement(node.index))
        return self._resolved(node)

    def _unknown(self, name: Name) -> _Unknown:
        text = name.text
        if text in self.symbols.labels:
            return _Unknown(name, f"{text} is a label, which has no value", "a variable, a bit or a number")
        if text in self.symbols.routines:
            return _Unknown(name, f"{text} is a routine, which has no value", "CALL before it, or a variable")
        if text in self._raw:  # its own definition is wrong, and that has been reported
            return _Unknown(name, f"{text} has no meaning, see line {self._lines[text]}")
        looks = text[0] + text[1:].translate(_LOOKS_LIKE)
        if len(text) > 1 and text[0] in instructions.RANGES and looks[1:].isdigit():
            return _Unknown(name, f"{text} is not defined; did you mean {looks}?", f"{text} EQU, or {looks}")
        if text in _LEVELS:
            return _Unknown(name, f"{text} is not defined; did you mean {_LEVELS[text]}?", _LEVELS[text])
        close = get_close_matches(text, sorted(self._raw), n=1)
        hint = f"; did you mean {close[0]}?" if close else ""
        return _Unknown(name, f"{text} is not defined{hint}", f"a line {text} EQU ...")

    def _say(self, line: int, column: int, what: str, expected: str) -> None:
        self.mistakes.append(Mistake(line, column, what, expected))
