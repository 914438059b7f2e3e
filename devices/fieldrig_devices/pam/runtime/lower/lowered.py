"""The result of lowering an application: routines, formulas, and what sequences do at their service statements."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Literal

from fieldrig.coverage.places import Marked
from fieldrig_devices.languages.instructions import Routine
from fieldrig_devices.pam.language.functions import Type
from fieldrig_devices.pam.language.tree import Place
from fieldrig_devices.pam.runtime.lower.formulas import Formula, Formulas
from fieldrig_devices.pam.runtime.lower.uses import Uses


@dataclass(frozen=True, slots=True)
class ConditionSite:
    """CONDITION: what a sequence waits for."""

    formula: Formula


@dataclass(frozen=True, slots=True)
class CaseSite:
    """CASE: the conditions with the sequences that they start, in their order, and that of the time-out."""

    branches: tuple[tuple[Formula, str], ...]
    on_timeout: str | None
    marks: tuple[int, ...] = ()
    """The marks of the branches, and of the time-out; empty unless coverage is wanted."""


@dataclass(frozen=True, slots=True)
class StartSite:
    """XEQ_TASK."""

    task: str
    sequence: str
    is_indexed: bool
    mode: Literal["", "WAIT", "ABORT"]


@dataclass(frozen=True, slots=True)
class Entry:
    """The instruction after an EXCEPTION_ENTRY."""

    pc: int


@dataclass(frozen=True, slots=True)
class Abort:
    pass


@dataclass(frozen=True, slots=True)
class Switch:
    """Another sequence of the same task."""

    sequence: str


ExceptionAction = Switch | Entry | StartSite | Abort


@dataclass(frozen=True, slots=True)
class ExceptionSite:
    """EXCEPTION: its event and what it does."""

    formula: Formula
    action: ExceptionAction


Site = ConditionSite | CaseSite | StartSite | ExceptionSite | Switch


@dataclass(frozen=True, slots=True)
class SequenceCode:
    """A sequence, or the POWERON part of a task, which has no name."""

    number: int
    """nnn of Snnn, as the listing and the message about workspaces show it."""
    task: str
    name: str
    routine: str
    place: Place
    workspace: int
    """Bytes that it gets (PAML-300)."""
    used: int
    """Bytes that it needs, by the model of `sizes`."""
    is_per_item: bool


@dataclass(frozen=True, slots=True)
class EventCode:
    formula: Formula
    sequence: str
    is_indexed: bool


@dataclass(frozen=True, slots=True)
class TaskCode:
    name: str
    count: int
    cycles: int
    duplicates: int | None
    events: tuple[EventCode, ...]
    sequences: dict[str, SequenceCode]
    power_on: SequenceCode | None


@dataclass(frozen=True, slots=True)
class ReactionCode:
    is_event: bool
    formula: Formula
    routine: str


@dataclass(frozen=True, slots=True)
class ActionsCode:
    name: str
    count: int
    cycles: int
    reactions: tuple[ReactionCode, ...]


@dataclass(frozen=True, slots=True)
class PowerOnCode:
    """The POWERON part of a group of actions or routines."""

    owner: str
    routine: str
    is_per_item: bool


@dataclass(frozen=True, slots=True)
class EquationCode:
    name: str
    first: int
    count: int
    formula: Formula
    linked_output: str | None
    is_multiple: bool


@dataclass(slots=True)
class Lowered:
    routines: dict[str, Routine] = field(default_factory=dict)
    titles: dict[str, str] = field(default_factory=dict)
    """The names of the routines for people, such as TSK_a.SEQ_b."""
    files: list[str] = field(default_factory=list)
    """The source files; a line of a routine has the number of its file as millions."""
    formulas: Formulas = field(default_factory=Formulas)
    uses: Uses = field(default_factory=Uses)
    sites: list[Site] = field(default_factory=list)
    signatures: dict[str, list[tuple[Type, ...]]] = field(default_factory=dict)
    """The types of arguments with which each routine is called or connected."""
    tasks: list[TaskCode] = field(default_factory=list)
    actions: list[ActionsCode] = field(default_factory=list)
    power_on: list[PowerOnCode] = field(default_factory=list)
    equations: list[EquationCode] = field(default_factory=list)
    order: list[str] = field(default_factory=list)
    """The names of actions and tasks in the order of their declarations (G-16)."""
    marked: Marked = field(default_factory=Marked)
    """The marks in the code; empty unless coverage is wanted."""
    stack_size: int = 0
    """The most cells that formal parameters need at a time."""

    def line(self, place: Place) -> int:
        """Return a line of a file as one number."""
        if place.file not in self.files:
            self.files.append(place.file)
        return self.files.index(place.file) * LINES + place.line

    def number_of_line(self, file: str, line: int) -> int:
        """Return a line of a file as one number; -1 for a file without code."""
        return self.files.index(file) * LINES + line if file in self.files else -1

    def place(self, line: int) -> tuple[str, int]:
        """Return the file and the line in it of such a number."""
        number, own = divmod(line, LINES)
        return self.files[number], own

    def sequences(self) -> Sequence[SequenceCode]:
        """Return all sequences in the order of their numbers."""
        all_sequences = [sequence for task in self.tasks for sequence in task.sequences.values()]
        all_sequences += [task.power_on for task in self.tasks if task.power_on is not None]
        return sorted(all_sequences, key=lambda sequence: sequence.number)


LINES = 10_000_000
"""More than the lines of any source file."""


def routine_name(routine: str, types: Sequence[Type]) -> str:
    """Return the name of the code of a routine for arguments of these types."""
    return "".join([f"routine {routine}", *(f" {value_type}" for value_type in types)])
