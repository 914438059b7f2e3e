"""Test files for the checker: TEST blocks become function blocks, and assertions native calls."""

from collections.abc import Collection, Sequence
from dataclasses import dataclass, field, replace
from typing import Final

from fieldrig_devices.iec import tree
from fieldrig_devices.iec.check.checker import Checker
from fieldrig_devices.iec.check.project import Project
from fieldrig_devices.iec.program import AnyStatement, Expression, Pou, Program
from fieldrig_devices.iec.testing.assertions import Assertion, Assertions
from fieldrig_devices.iec.testing.mocks import Mocks
from fieldrig_devices.iec.testing.program_variables import ProgramVariables
from fieldrig_devices.iec.testing.words import CALLS, WORDS
from fieldrig_devices.iec.tree import PouKind
from fieldrig_devices.languages.mistakes import Mistake

TEARDOWN: Final = "TEARDOWN"
BEGIN: Final = "BEGIN of tests"
"""A block with nothing of its own, which runs once before all tests: it starts the variables of the program."""
BEGIN_INSTANCE: Final = f"{BEGIN} instance"


@dataclass(slots=True)
class CaseBlock:
    """One TEST as a function block with one instance."""

    test: tree.Test
    file: str
    pou: str
    """The name of the block, which no program can have."""
    rig: tree.RigUse | None = None
    places: dict[str, str] = field(default_factory=dict)
    """The points and wires of the rig behind AT, by the names of the variables."""
    has_teardown: bool = False

    @property
    def instance(self) -> str:
        return f"{self.pou} instance"


class CaseExtension:
    """Implements `check.extension.Extension` for the test files of one compilation."""

    def __init__(self, mocked: Sequence[str] = ()) -> None:
        """`mocked` are the names of functions and blocks that Python takes the place of."""
        self.blocks: list[CaseBlock] = []
        self.mistakes: list[Mistake] = []
        """Mistakes of the blocks of test files, besides what the checker finds."""
        self._mocked = mocked
        self._files: set[str] = set()
        self.mocks = Mocks()
        self._assertions = Assertions(self.mocks)

    @property
    def assertions(self) -> Sequence[Assertion]:
        """All assertions by number."""
        return self._assertions.all

    def units(self, units: Sequence[tree.Unit]) -> Sequence[tree.Unit]:
        programs = ProgramVariables(units)
        made = [self._unit(unit, programs) if unit.tests else unit for unit in units]
        return [*map(programs.with_copies, made), begin_unit()]

    def _unit(self, unit: tree.Unit, programs: ProgramVariables) -> tree.Unit:
        self._files.add(unit.file)
        parts: dict[tree.TestWord, tree.Test] = {}
        names: dict[str, tree.Test] = {}
        for test in unit.tests:
            if test.word is tree.TestWord.TEST:
                self._check_name(unit, test, names)
            elif test.word in parts:
                line = parts[test.word].position.line
                self._say(unit, test, f"a second {test.word.value}, besides the one in line {line}", "one in a file")
            parts.setdefault(test.word, test)
        setup, teardown = parts.get(tree.TestWord.SETUP), parts.get(tree.TestWord.TEARDOWN)
        made: list[tree.Declaration] = []
        for test in names.values():
            made += self._block(unit, test, programs.replaced([part for part in (setup, test, teardown) if part]))
        return replace(unit, declarations=(*unit.declarations, *made))

    def _check_name(self, unit: tree.Unit, test: tree.Test, names: dict[str, tree.Test]) -> None:
        if test.name in names:
            line = names[test.name].position.line
            self._say(unit, test, f"the test {test.name!r} exists already in line {line}", "another name")
        elif not test.name.strip():
            self._say(unit, test, "a test without a name", "TEST 'what it shows'")
        else:
            names[test.name] = test

    def _say(self, unit: tree.Unit, node: tree.Node, what: str, expected: str) -> None:
        self.mistakes.append(Mistake(*node.position, what, expected, file=unit.file))

    def _block(self, unit: tree.Unit, test: tree.Test, parts: Sequence[tree.Test]) -> list[tree.Declaration]:
        """Return a TEST with the SETUP and the TEARDOWN of its file, if there are any, as a function block."""
        blocks = tuple(block for part in parts for block in part.blocks)
        made = CaseBlock(test, unit.file, f"TEST {len(self.blocks) + 1}", test.rig or unit.rig)
        made.places = {
            variable.name: variable.place for block in blocks for variable in block.variables if variable.place
        }
        if made.places and made.rig is None:
            self._say(unit, test, f"{next(iter(made.places))} is at a place of a rig", "RIG 'file.yaml' in the test")
        self.blocks.append(made)
        teardown = next((part for part in parts if part.word is tree.TestWord.TEARDOWN), None)
        statements = tuple(one for part in parts if part is not teardown for one in _statements(part))
        actions: tuple[tree.Action, ...] = ()
        if teardown is not None:
            made.has_teardown = True
            actions = (tree.Action(TEARDOWN, tree.StBody(_statements(teardown)), position=teardown.position),)
        position = test.position
        pou = tree.Pou(
            tree.PouKind.FUNCTION_BLOCK,
            made.pou,
            None,
            blocks,
            tree.StBody(statements),
            actions,
            position=position,
        )
        variable = tree.Variable(made.instance, tree.NamedType(made.pou, position=position), position=position)
        return [pou, tree.Variables(tree.Section.GLOBAL, (variable,), position=position)]

    # ---- for the checker

    def begin(self, project: Project) -> None:
        self._assertions.begin(project)
        self.mocks.begin(project, self._mocked)

    def applies(self, file: str) -> bool:
        return file in self._files

    @property
    def words(self) -> Collection[str]:
        return WORDS

    def statement(self, checker: Checker, node: tree.Call, line: int) -> list[AnyStatement] | None:
        name = node.called.text.upper() if isinstance(node.called, tree.Name) else ""
        word = WORDS.get(name)
        named = checker.context.find(name)
        is_type = isinstance(named, Pou) and named.kind is PouKind.FUNCTION_BLOCK  # which nothing calls
        if word is None or (named is not None and not is_type):
            return None
        return self._assertions.statement(checker, name, word, node, line)

    def has_value(self, node: tree.Call) -> bool:
        return isinstance(node.called, tree.Name) and node.called.text.upper() == CALLS

    def value(self, checker: Checker, node: tree.Call) -> Expression | None:
        return self._assertions.calls(checker, node)

    def first(self, project: Project) -> Sequence[Pou]:
        return [project.pous[project.key(BEGIN)]]

    def finish(self, program: Program) -> None:
        self.mocks.finish()


def _statements(part: tree.Test) -> tuple[tree.AnyStatement, ...]:
    return part.body.statements if isinstance(part.body, tree.StBody) else ()


def begin_unit() -> tree.Unit:
    """Return the declaration of the block that runs first."""
    block = tree.Pou(tree.PouKind.FUNCTION_BLOCK, BEGIN, None, (), tree.StBody(()))
    instance = tree.Variable(BEGIN_INSTANCE, tree.NamedType(BEGIN))
    return tree.Unit(BEGIN, (block, tree.Variables(tree.Section.GLOBAL, (instance,))))
