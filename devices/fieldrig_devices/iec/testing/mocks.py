"""Mocks: functions and blocks that count their calls, and do something else than their code."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from fieldrig_devices.iec.check.project import Project
from fieldrig_devices.iec.elementary import Elementary
from fieldrig_devices.iec.program import (
    AnyStatement,
    Assign,
    Binary,
    Component,
    Constant,
    If,
    Load,
    Operator,
    Place,
    Pou,
    Return,
    Space,
    Variable,
)
from fieldrig_devices.iec.testing.natives import MOCKED, call_of, cell, native_pou
from fieldrig_devices.iec.tree import PouKind, Section
from fieldrig_devices.iec.types import Type

_WITH_INSTANCES: Final = (PouKind.FUNCTION_BLOCK, PouKind.PROGRAM)


@dataclass(slots=True)
class Mock:
    """A function, a method or a block whose calls are counted; each instance counts those of its block and methods."""

    pou: Pou
    is_on: Variable
    """TRUE where the code does not run."""
    calls: Variable
    value: Variable | None
    """The result of a function then."""
    number: int = -1
    """The number of the Python function that is called instead; -1 if there is none."""

    @property
    def first(self) -> Variable:
        """The variable whose address tells Python where those of a call are."""
        if self.pou.kind is not PouKind.FUNCTION:
            return self.is_on
        return self.pou.result or next(iter(self.pou.variables.values()), self.is_on)

    def place(self, variable: Variable, instance: Place | None) -> Place:
        return cell(variable) if instance is None else Component(instance, 0, variable.type, variable)


class Mocks:
    """All mocks of a compilation."""

    def __init__(self) -> None:
        self._mocks: dict[Pou, Mock] = {}
        self._native = native_pou(MOCKED)
        self.by_number: list[Mock] = []
        """The mocks that Python answers."""
        self.unknown: list[str] = []
        """Names of mocks for Python that nothing of the project has."""

    def begin(self, project: Project, names: Sequence[str]) -> None:
        self._project = project
        project.pous[MOCKED] = self._native
        for name in names:
            pou = project.pous.get(project.key(name))
            if pou is None or pou.is_native or not self.may_be(pou):
                self.unknown.append(name)
                continue
            mock = self.of(pou)
            mock.number = len(self.by_number)
            self.by_number.append(mock)

    @staticmethod
    def may_be(pou: Pou) -> bool:
        """True for functions, methods and blocks, and false for actions."""
        kinds = (PouKind.FUNCTION,) if pou.owner is not None else (PouKind.FUNCTION, *_WITH_INSTANCES)
        return pou.kind in kinds

    def of(self, pou: Pou) -> Mock:
        """Return the mock of a function or block, made at its first use."""
        if pou not in self._mocks:
            value = None
            if pou.result is not None and pou.kind is PouKind.FUNCTION:
                value = self._variable(pou, "value", pou.result.type)
            is_on, calls = self._variable(pou, "mocked", Elementary.BOOL), self._variable(pou, "calls", Elementary.DINT)
            self._mocks[pou] = Mock(pou, is_on, calls, value)
        return self._mocks[pou]

    def _variable(self, pou: Pou, what: str, kind: Type) -> Variable:
        """Make a variable of each instance; a function has it once."""
        if pou.owner is not None:
            name = f"${what} of {pou.name.lower()}"
            made = Variable(name, kind, Space.INSTANCE, Section.LOCAL, file=pou.file)
            pou.owner.variables[name] = made
            return made
        if pou.kind is PouKind.FUNCTION:
            name = f"${what} of {pou.name.lower()}"
            made = Variable(name, kind, Space.GLOBAL, Section.GLOBAL, file=pou.file)
            self._project.globals[name] = made
            return made
        name = f"${what}"
        made = Variable(name, kind, Space.INSTANCE, Section.LOCAL, file=pou.file)
        pou.variables[name] = made
        return made

    def finish(self) -> None:
        """Put the mocks in front of the code."""
        for pou, mock in self._mocks.items():
            pou.body[:0] = _prologue(mock, self._native)


def _prologue(mock: Mock, native: Pou) -> list[AnyStatement]:
    pou = mock.pou
    line = pou.body[0].line if pou.body else 0
    one = Binary(Operator.ADD, Load(cell(mock.calls)), Constant(1, Elementary.DINT), Elementary.DINT)
    instead: list[AnyStatement] = []
    by_python: list[AnyStatement] = []
    if mock.number >= 0:
        by_python.append(If(call_of(native, mock.number, cell(mock.first)), [Return(line=line)], line=line))
    if mock.value is not None and pou.result is not None:
        instead.append(Assign(cell(pou.result), Load(cell(mock.value)), line=line))
    return [
        Assign(cell(mock.calls), one, line=line),
        *by_python,
        If(Load(cell(mock.is_on)), [*instead, Return(line=line)], line=line),
    ]
