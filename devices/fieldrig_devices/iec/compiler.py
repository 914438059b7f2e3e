"""Compiles source files to a program: parse, check, place, lower, and compile the Python.

The result can be pickled, so that another process can do the work (PD-032 to PD-034: what does not compile is never
loaded).  All mistakes of all files are reported at once.
"""

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, field

from fieldrig.coverage import collecting
from fieldrig_devices.iec import layout, memory_functions
from fieldrig_devices.iec.check import check
from fieldrig_devices.iec.check.extension import Extension
from fieldrig_devices.iec.configured_instances import configured
from fieldrig_devices.iec.costs import Costs
from fieldrig_devices.iec.dialect import EPAS_4, Dialect
from fieldrig_devices.iec.generics import expanded
from fieldrig_devices.iec.host import Host, NativeBlock, NativeFunction
from fieldrig_devices.iec.imports import read_sources
from fieldrig_devices.iec.layout import Layout
from fieldrig_devices.iec.library.selection import needed
from fieldrig_devices.iec.library.sources import parsed, sources
from fieldrig_devices.iec.limits import MAX_4, MOST_CHARACTERS, MOST_STATEMENTS, Limits
from fieldrig_devices.iec.lower.names import names_of, rules_of
from fieldrig_devices.iec.lower.routines import Lowered, lower
from fieldrig_devices.iec.mutation.switch import changed, refuse
from fieldrig_devices.iec.open_inputs import open_inputs
from fieldrig_devices.iec.program import Pou, Program, Task
from fieldrig_devices.iec.program_instances import separated
from fieldrig_devices.iec.symbols import Symbols
from fieldrig_devices.iec.tree import Unit
from fieldrig_devices.iec.written import NOTHING, Written, surveyed, written_by
from fieldrig_devices.languages.garbage import collection
from fieldrig_devices.languages.mistakes import CompileError, Mistake
from fieldrig_devices.languages.resumable import prepare
from fieldrig_devices.languages.source_file import SourceFile

Progress = Callable[[str, int, int], None]
"""Called with the present stage, the number of things that are done, and their total."""


@dataclass(slots=True)
class Compiled:
    program: Program
    """The declarations; the bodies of the POUs are only in the code."""
    code: Lowered
    layout: Layout
    files: tuple[SourceFile, ...] = ()
    notes: tuple[Mistake, ...] = ()
    costs: Costs = field(default_factory=Costs)
    written: Written = NOTHING
    """The places that the program writes, so that a device can refuse them to tools and masters."""

    @property
    def code_size(self) -> int:
        """Bytes of machine code by the model in `costs.py` (PD-311)."""
        return self.code.code_size

    @property
    def data_size(self) -> int:
        """Bytes of the variables (PD-312)."""
        return self.layout.data_size

    @property
    def tasks(self) -> Sequence[Task]:
        return self.program.tasks

    @property
    def symbols(self) -> Symbols:
        return Symbols(self.program, {file.name for file in self.files})


def compile_project(
    files: Sequence[SourceFile],
    host: Host,
    dialect: Dialect = EPAS_4,
    *,
    limits: Limits = MAX_4,
    previous: Layout | None = None,
    costs: Costs | None = None,
    resource: str = "",
    extension: Extension | None = None,
    on_progress: Progress = lambda stage, done, total: None,
    in_advance: bool = True,
) -> Compiled:
    """Compile a project; CompileError with all mistakes if it has any.

    With `previous`, the layout of the running program, variables of the same name and type keep their places, so that
    the result can be loaded as an online change.  `limits` are those of the controller, and `resource` is the name of
    the RESOURCE that it runs if the project has several.  An `extension` adds what tests of programs need.

    The Python of all routines is made `in_advance`, for the process that runs them; without it each becomes Python when
    it is first called, which is less work where few are.
    """
    with collection.paused():
        compiled = _compiled(files, host, dialect, limits, previous, costs or Costs(), resource, extension, on_progress)
        if in_advance:
            _compile_routines(compiled.code, lambda done, total: on_progress("compile", done, total))
        return compiled


def _compiled(
    files: Sequence[SourceFile],
    host: Host,
    dialect: Dialect,
    limits: Limits,
    previous: Layout | None,
    costs: Costs,
    resource: str,
    extension: Extension | None,
    on_progress: Progress,
) -> Compiled:
    _check_sources(files)
    units, mistakes = [], list[Mistake]()
    libraries = [parsed(text, name, dialect) for name, text in sources(dialect.name)]
    libraries += [parsed(library.text, library.name, dialect) for library in host.libraries]
    read = read_sources(files, dialect, libraries, lambda number: on_progress("parse", number, len(files)))
    for file, (unit, of_file) in zip(files, read, strict=True):
        units.append(unit)
        mistakes += of_file
        if not unit.declarations and not unit.tests and not of_file:
            mistakes.append(_nothing_in(file))
    on_progress("parse", len(files), len(files))
    libraries = needed(libraries, units, (file.text for file in files))
    units = list(changed(units))
    if extension is not None:
        units = list(extension.units(units))
    program, of_program = _checked(libraries, units, host, dialect, limits, resource, extension, on_progress)
    mistakes += of_program
    if any(not mistake.is_note for mistake in mistakes):
        refuse(file.name for file in files)
        raise CompileError(sorted(mistakes, key=lambda mistake: (mistake.file, mistake.line, mistake.column)))
    return build(program, host, costs, limits, previous, tuple(files), tuple(mistakes), on_progress)


def _compile_routines(lowered: Lowered, on_progress: Callable[[int, int], None]) -> None:
    has_marks = bool(lowered.marked.hits)
    names = names_of(len(lowered.constants), len(lowered.natives), has_marks=has_marks)
    prepare(lowered.routines, names, rules_of(len(lowered.constants), has_marks=has_marks), on_progress)


def compile_units(
    libraries: Sequence[Unit],
    units: Sequence[Unit],
    host: Host,
    dialect: Dialect,
    limits: Limits,
    uncovered: Collection[str] = (),
) -> Compiled:
    """Compile units that have been read already, with those parts of the libraries that are needed.

    No Python is made in advance: suites reach so little of their libraries that a small one takes three quarters of the
    time.

    CompileError with all mistakes if there are any.  Coverage leaves out the POUs whose names in small letters are
    `uncovered`, and so do changes of programs.
    """
    with collection.paused():
        program, mistakes = _checked(libraries, changed(units, uncovered), host, dialect, limits)
        if any(not mistake.is_note for mistake in mistakes):
            refuse(unit.file for unit in units)
            raise CompileError(mistakes)
        files = tuple(SourceFile(unit.file, "") for unit in units)
        return build(program, host, Costs(), limits, None, files, tuple(mistakes), uncovered=uncovered)


def _checked(
    libraries: Sequence[Unit],
    units: Sequence[Unit],
    host: Host,
    dialect: Dialect,
    limits: Limits,
    resource: str = "",
    extension: Extension | None = None,
    on_progress: Progress = lambda stage, done, total: None,
) -> tuple[Program, list[Mistake]]:
    units, of_generics = expanded(configured(separated(units, dialect), dialect, resource), dialect)
    program, mistakes = check(
        [*libraries, *units],
        host,
        dialect,
        library_files=[unit.file for unit in libraries],
        limits=limits,
        resource=resource,
        extension=extension,
        on_progress=lambda done, total: on_progress("check", done, total),
    )
    return program, [*of_generics, *mistakes]


def _nothing_in(file: SourceFile) -> Mistake:
    hint = "write PROGRAM PLC_PRG ... END_PROGRAM, for example"
    return Mistake(1, 1, "there is nothing in this file", file=file.name, hint=hint, is_note=True)


def build(
    program: Program,
    host: Host,
    costs: Costs,
    limits: Limits = MAX_4,
    previous: Layout | None = None,
    files: tuple[SourceFile, ...] = (),
    notes: tuple[Mistake, ...] = (),
    on_progress: Progress = lambda stage, done, total: None,
    uncovered: Collection[str] = (),
) -> Compiled:
    """Place and lower a checked program."""
    placed = layout.place(program, previous)
    natives: dict[str, NativeFunction | NativeBlock] = {**memory_functions.natives()}
    for library in host.libraries:
        natives |= {**library.functions, **library.blocks}
    is_covered = _covered(files, uncovered) if collecting.is_on() else _nothing_is_covered
    lowered = lower(program, natives, costs, lambda done, total: on_progress("lower", done, total), is_covered)
    paths = {file.name: str(file.path or file.name) for file in files}
    lowered.marked.locate(paths.__getitem__)
    survey = surveyed(lowered.callees_first)
    missing = list(open_inputs(survey.mentioned, {name for library in host.libraries for name in library.required}))
    if missing:
        raise CompileError(missing)
    compiled = Compiled(program, lowered, placed, files, notes, costs, written_by(program, survey))
    _check_limits(compiled, limits)
    for pou in program.pous.values():
        pou.body = []
        for action in pou.actions.values():
            action.body = []
    return compiled


def _nothing_is_covered(_pou: Pou) -> bool:
    return False


def _covered(files: Sequence[SourceFile], uncovered: Collection[str]) -> Callable[[Pou], bool]:
    """Return which POUs are the user's own, and no tests: names of what is made have what no name of the source has."""
    own = {file.name for file in files}

    def is_covered(pou: Pou) -> bool:
        outer = pou
        while outer.owner is not None:
            outer = outer.owner
        return pou.file in own and not {" ", "$"} & {*pou.name} and outer.name.casefold() not in uncovered

    return is_covered


def _check_sources(files: Sequence[SourceFile]) -> None:
    """Refuse sources that are far too large before they take time and memory."""
    hint = "Divide the project between several controllers, or leave out what the program does not use."
    characters = statements = 0
    for file in files:
        characters += len(file.text)
        statements += file.text.count(";")
        if characters > MOST_CHARACTERS:
            what, expected = "the sources are too long up to here", f"at most {MOST_CHARACTERS} characters together"
        elif statements > MOST_STATEMENTS:
            what, expected = "there are too many statements up to here", f"at most {MOST_STATEMENTS} together"
        else:
            continue
        raise CompileError([Mistake(1, 1, what, expected, file=file.name, hint=hint)])


def _check_limits(compiled: Compiled, limits: Limits) -> None:
    mistakes = []
    if compiled.code_size > limits.code:
        what = f"the program has {compiled.code_size} bytes of code"
        mistakes.append(Mistake(1, 1, what, f"at most {limits.code}", file=_first(compiled)))
    if compiled.data_size > limits.variables:
        what = f"the variables take {compiled.data_size} bytes"
        mistakes.append(Mistake(1, 1, what, f"at most {limits.variables}", file=_first(compiled)))
    if mistakes:
        raise CompileError(mistakes)


def _first(compiled: Compiled) -> str:
    return compiled.files[0].name if compiled.files else ""
