"""A project with suites as a program: what can be compiled is, and what cannot is listed with the reason."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import Final

from fieldrig_devices.iec import tree
from fieldrig_devices.iec.compiler import Compiled, compile_units
from fieldrig_devices.iec.dialect import CODESYS
from fieldrig_devices.iec.host import Host
from fieldrig_devices.iec.library.selection import needed
from fieldrig_devices.iec.library.selection import words as words_of
from fieldrig_devices.iec.library.sources import parsed, sources
from fieldrig_devices.iec.limits import Limits
from fieldrig_devices.iec.parser import parse
from fieldrig_devices.iec.tcunit import library, partial, reach
from fieldrig_devices.iec.tcunit.project import Sources, overriding
from fieldrig_devices.iec.tcunit.reach import Item, Units
from fieldrig_devices.languages.mistakes import Code, CompileError, Mistake

MAIN: Final = "PRG_TEST"
"""The program that is made if the project has none that calls RUN."""
MADE: Final = "<tests>"
"""The name of the file of what is made here."""
MOST_ATTEMPTS: Final = 100
_MB: Final = 1 << 20
NO_LIMITS: Final = Limits(
    code=1 << 40,
    data=1 << 40,
    retain=1 << 40,
    variable=256 * _MB,
    stack=1 << 30,
    if_depth=1_000,
    parts=20_000_000,
)
"""A test runs on no controller, so that its memory has no limit but that of the host."""


@dataclass(frozen=True, slots=True)
class LeftOut:
    """A unit that a suite names and that is not compiled."""

    name: str
    is_suite: bool
    reason: Mistake
    file: str = ""
    line: int = 0
    words: frozenset[str] = frozenset()
    """The words in it, in small letters."""
    is_part: bool = False
    """True for a body that is left out while the unit around it runs; a run that reaches it gets a fault."""


@dataclass(slots=True)
class TestProgram:
    compiled: Compiled
    left_out: list[LeftOut]
    """The units that could not be compiled, each once with the first reason."""
    interval_ms: float
    items: Sequence[Item] = field(default_factory=list)
    reached: int = 0
    """The number of units that the suites reach."""
    is_sequence: bool = False


class NothingToRunError(Exception):
    """The project has no suite."""


def built(given: Sources, host: Host) -> TestProgram:
    """Compile the suites of a project.

    NothingToRunError if it has none; CompileError if not even a program without the suites compiles.
    """
    units = Units()
    units.add(given.files, is_ours=True)
    units.add(given.library_files, is_ours=False)
    return _Builder(units, given, host).build()


class _Builder:
    def __init__(self, units: Units, given: Sources, host: Host) -> None:
        self._units, self._given, self._host = units, given, host
        self._order = {file.name: number for number, file in enumerate((*given.library_files, *given.files))}
        self._left_out: dict[Item, LeftOut] = {}
        self._stubs: dict[Item, Item] = {}
        """The suites that cannot run, each with a suite without tests that is in its place."""
        self._changed: dict[Item, Item] = {}
        """The units of which a part is left out, each with what is in its place."""
        self._placeholders: dict[str, Item] = {}
        """The blocks in the place of types that are not there, by the names of these in small letters."""
        self._missing: dict[str, Mistake] = {}
        """The mistakes that first name these types."""
        self._parts: list[LeftOut] = []
        self._settled: set[Mistake] = set()
        """The mistakes of the parser in parts that are left out."""
        self._libraries = _libraries(host)

    def build(self) -> TestProgram:
        roots = self._roots()
        before: Sequence[Mistake] = ()
        for _ in range(MOST_ATTEMPTS):
            items = [self._stubs.get(item, item) for item in self._reached(roots)]
            try:
                compiled = self._compiled(items, roots)
            except CompileError as wrong:
                is_stuck = wrong.mistakes == before
                before = wrong.mistakes
                if is_stuck or not self._leave_out(items, wrong.mistakes, roots):
                    behind = [one.reason for one in self._left_out.values()]
                    raise CompileError([*behind, *wrong.mistakes]) from None
                continue
            left_out = [*self._left_out.values(), *self._doubles(), *self._parts]
            return TestProgram(compiled, left_out, self._interval_ms(roots), items, len(items))
        raise CompileError([one.reason for one in self._left_out.values()])

    def _doubles(self) -> Iterator[LeftOut]:
        """Yield the suites whose name another unit of the project has."""
        for first, item in self._units.doubles:
            if reach.is_suite(self._units, item):
                what = f"{item.title} is declared in {first.file}, line {first.line} already"
                reason = Mistake(item.line, 1, what, "a name that is unique in the project", file=item.file)
                yield LeftOut(item.title, True, reason, item.file, item.line)

    # ---- what runs

    def _roots(self) -> list[Item]:
        """Return the programs that call RUN, and the global variables that are suites."""
        units = self._units
        for name in units.texts_with({*reach.RUN, reach.SUITE}):
            units.named(name)
        ours = {item: None for items in units.by_name.values() for item in items if item.is_ours}
        programs = [item for item in ours if _is_program(item) and reach.calls_run(item.declaration)]
        callers = {item.name for item in ours if not _is_program(item) and reach.calls_run(item.declaration)}
        if not programs and callers:
            for name in units.texts_with(callers):
                units.named(name)
            ours = {item: None for items in units.by_name.values() for item in items if item.is_ours}
            programs = [item for item in ours if _is_program(item) and item.words & callers]
        in_tasks = {one.type.casefold() for task in units.tasks for one in task.programs}
        programs = [item for item in programs if item.name in in_tasks] or programs
        suites = [item for item in ours if isinstance(item.declaration, tree.Pou) and reach.is_suite(units, item)]
        if not suites:
            raise NothingToRunError("expected a function block that extends FB_TestSuite")
        names = {item.name for item in suites}
        variables = [item for item in ours if isinstance(item.declaration, tree.Variables) and item.words & names]
        if not programs:
            programs = [self._made_program(suites, variables)]
        return [*programs, *variables]

    def _made_program(self, suites: Sequence[Item], variables: Sequence[Item]) -> Item:
        """Return a program with an instance of each suite that no global variable has."""
        declared = {word for item in variables for word in item.words}
        wanted = [
            item.title
            for item in suites
            if item.name not in declared and "ABSTRACT" not in getattr(item.declaration, "modifiers", ())
        ]
        lines = "\n".join(f"{name.removeprefix('FB_')}_ : {name};" for name in wanted)
        title = MAIN
        while self._units.named(title.casefold()):  # a library may bring its own tests
            title += "_"
        text = f"PROGRAM {title}\nVAR\n{lines}\nEND_VAR\nTcUnit.RUN();\nEND_PROGRAM\n"
        unit, mistakes = parse(text, MADE, CODESYS)
        if mistakes:
            raise CompileError(mistakes)
        declaration = unit.declarations[0]
        return Item(title.casefold(), MADE, 1, declaration, True, frozenset(words_of(declaration)))

    def _interval_ms(self, roots: Sequence[Item]) -> float:
        names = {item.name for item in roots}
        for task in self._units.tasks:
            if any(one.type.casefold() in names for one in task.programs):
                for declared in task.tasks:
                    if isinstance(declared.interval, tree.Literal):
                        return float(declared.interval.value)
        return 10.0

    # ---- attempts

    def _reached(self, roots: Sequence[Item]) -> list[Item]:
        without = [item for item in self._left_out if item not in self._stubs]
        found = reach.closure(self._units, roots, without, self._changed)
        words = {word for item in found for word in item.words}
        made = [item for name, item in self._placeholders.items() if name in words]
        return [*(item for item in found if item not in without), *made]

    def _compiled(self, items: Sequence[Item], roots: Sequence[Item]) -> Compiled:
        programs = [item for item in items if item in roots and _is_program(item)]
        units = [*reach.as_units(items, self._order), _configuration(programs, self._interval_ms(roots))]
        words = " ".join((*library.PARAMETERS, *(word for item in items for word in item.words)))
        given = [unit for unit in units if unit.file != MADE or unit.declarations]
        libraries = needed([*self._libraries], given, (words,))
        libraries = [_without_unused(unit, set(words.split())) for unit in libraries]
        libraries, given = [self._with_parameters(unit) for unit in libraries], [*map(self._with_parameters, given)]
        mistakes = [
            mistake
            for file in dict.fromkeys(item.file for item in items)
            for mistake in self._units.mistakes.get(file, ())
            if not mistake.is_note and not self._is_stubbed(file) and mistake not in self._settled
        ]
        mistakes += partial.unknown_sizes(items, self._placeholders)
        if mistakes:
            raise CompileError(mistakes)
        return compile_units(libraries, given, self._host, CODESYS, NO_LIMITS, self._uncovered(items))

    def _uncovered(self, items: Sequence[Item]) -> frozenset[str]:
        """Return what is no code under test: the suites, what is made here, and the libraries of the project."""
        return frozenset(
            item.name for item in items if item.file == MADE or not item.is_ours or reach.is_suite(self._units, item)
        )

    def _is_stubbed(self, file: str) -> bool:
        return any(stub.file == file for stub in self._stubs.values())

    def _with_parameters(self, unit: tree.Unit) -> tree.Unit:
        """Return a unit with the constants that the project sets for the libraries."""
        declarations: list[tree.Declaration] = []
        for part in unit.declarations:
            if isinstance(part, tree.Variables) and part.name:
                given = dict(overriding(self._given.parameters, part.name))
                if given:
                    changed = tuple(_set(one, given.get(one.name.casefold())) for one in part.variables)
                    part = replace(part, variables=changed)
            declarations.append(part)
        return replace(unit, declarations=tuple(declarations))

    def _leave_out(self, items: Sequence[Item], mistakes: Iterable[Mistake], roots: Sequence[Item]) -> bool:
        """Leave out the units with mistakes; return whether there was one that can be left out."""
        wrong: dict[Item, Mistake] = {}
        is_new = False
        for said in mistakes:
            item = reach.place_of(items, said) if not said.is_note else None
            if item is None:
                continue
            mistake = reach.about_list(self._units, item, said)
            if self._leave_out_part(item, mistake, roots):
                is_new = True
            else:
                wrong.setdefault(item, mistake)
        for item, mistake in wrong.items():
            if item in self._stubs.values() or (item in roots and _is_program(item)):
                continue
            is_suite = reach.is_suite(self._units, item)
            self._left_out[item] = LeftOut(item.title, is_suite, mistake, item.file, item.line, item.words)
            if is_suite:
                self._stubs[item] = _stub(item)
            is_new = True
        return is_new

    def _leave_out_part(self, item: Item, mistake: Mistake, roots: Sequence[Item]) -> bool:
        """Leave out a type that is not there, or the body that a mistake is in; false if the unit cannot do without."""
        source = next((old for old, new in self._changed.items() if new is item), item)
        if source in roots or source in self._stubs or item in self._stubs.values():
            return False
        if reach.is_suite(self._units, source):
            return False
        item = self._changed.get(source, item)
        name = mistake.name if mistake.code is Code.NO_TYPE else ""
        if name and not self._units.named(name.casefold()):
            if name.casefold() not in self._placeholders:
                self._placeholders[name.casefold()] = partial.placeholder(name, mistake)
                self._missing[name.casefold()] = mistake
            return True
        reason = partial.cause(mistake, self._missing)
        found = partial.without_part(item, mistake, reason, self._missing)
        if found is None:
            return False
        self._changed[source], title = found
        self._settled.add(mistake)
        if title and title not in (one.name for one in self._parts):
            self._parts.append(LeftOut(title, False, reason, mistake.file, mistake.line, is_part=True))
        return True


def origins(suite: LeftOut, left_out: Sequence[LeftOut]) -> list[Mistake]:
    """Return why a suite is left out: its own mistake, and those of the units behind it that came first."""
    found, words, waiting = [suite], set(suite.words), [one for one in left_out if not one.is_suite]
    while new := [one for one in waiting if one.name.casefold() in words]:
        found += new
        waiting = [one for one in waiting if one not in new]
        words |= {word for one in new for word in one.words}
    order = {id(one): number for number, one in enumerate(left_out)}
    return [one.reason for one in sorted(found, key=lambda one: order[id(one)])]


def _is_program(item: Item) -> bool:
    return isinstance(item.declaration, tree.Pou) and item.declaration.kind is tree.PouKind.PROGRAM


def _stub(item: Item) -> Item:
    """Return a suite without tests in the place of one that cannot be compiled."""
    pou = item.declaration
    assert isinstance(pou, tree.Pou)
    position = pou.position
    blank = tree.Pou(pou.kind, pou.name, None, (), tree.StBody(()), extends=library.SUITE, position=position)
    return replace(item, declaration=blank, words=frozenset({reach.SUITE}))


def _libraries(host: Host) -> list[tree.Unit]:
    units = [parsed(text, name, CODESYS) for name, text in sources(CODESYS.name)]
    for one in host.libraries:
        unit = parsed(one.text, one.name, CODESYS)
        if one.name == library.FILE:
            first = unit.declarations[0]
            assert isinstance(first, tree.Variables)
            listed = replace(first)
            listed.name = library.LIST
            unit = replace(unit, declarations=(listed, *unit.declarations[1:]))
        units.append(unit)
    return units


def _without_unused(unit: tree.Unit, words: set[str]) -> tree.Unit:
    """Return the library without the asserts that nothing calls, which each suite would inherit."""
    kept: list[tree.Declaration] = []
    for part in unit.declarations:
        if isinstance(part, tree.Pou) and part.name == library.SUITE:
            methods = tuple(one for one in part.methods if one.name.casefold() in words or one.name == "FB_init")
            part = replace(part, methods=methods)
        kept.append(part)
    return replace(unit, declarations=tuple(kept))


def _configuration(programs: Sequence[Item], interval_ms: float) -> tree.Unit:
    """Return the task that runs the programs."""
    interval = tree.Literal(tree.LiteralKind.TIME, max(1, round(interval_ms)), "")
    task = tree.TaskDeclaration("Tests", None, interval)
    instances = tuple(tree.ProgramInstance(item.title, task.name, item.title) for item in programs)
    return tree.Unit(MADE, (tree.Configuration(task.name, (), (task,), instances),))


def _set(variable: tree.Variable, value: str | None) -> tree.Variable:
    """Return a constant with the value that a project gives it, if that is a constant of Structured Text."""
    if value is None:
        return variable
    if value == "1" and isinstance(variable.type, tree.NamedType) and variable.type.name.upper() == "BOOL":
        value = "TRUE"
    unit, mistakes = parse(f"VAR_GLOBAL CONSTANT x : INT := {value}; END_VAR", MADE, CODESYS)
    block = unit.declarations[0] if unit.declarations and not mistakes else None
    if not isinstance(block, tree.Variables) or not block.variables:
        return variable
    return replace(variable, initial=block.variables[0].initial)
