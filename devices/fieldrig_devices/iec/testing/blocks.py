"""The TEST blocks of one file as a source of cases."""

from collections.abc import Collection, Iterator, Sequence
from contextlib import closing
from itertools import groupby
from pathlib import Path
from typing import Final

from fieldrig.errors import RigError
from fieldrig_devices.begin.named_files import named_files
from fieldrig_devices.iec import tree
from fieldrig_devices.iec.dialect import Dialect
from fieldrig_devices.iec.mutation import switch
from fieldrig_devices.iec.testing import gathered
from fieldrig_devices.iec.testing.alone import Alone
from fieldrig_devices.iec.testing.case import FAULT, MISTAKE, TIMEOUT, Case, Failure, Limits, Outcome, Verdict
from fieldrig_devices.iec.testing.compiled import Tested, compile_tests
from fieldrig_devices.iec.testing.extension import CaseBlock
from fieldrig_devices.iec.testing.in_rig import Rigs, is_in
from fieldrig_devices.iec.testing.rig_places import mistakes_of_rigs
from fieldrig_devices.iec.testing.runner import Runner
from fieldrig_devices.languages.mistakes import Code, CompileError, Mistake

_NAMES: Final = frozenset({Code.NO_TYPE, Code.NO_FUNCTION})
COMPILES: Final = "the file compiles"
"""The name of the case of a file whose tests cannot be found."""


class BlockSource:
    """Implements `case.Source` for one test file."""

    def __init__(self, file: Path, dialect: Dialect, elsewhere: Sequence[Path] = ()) -> None:
        """Code that is not beside the file is looked for in `elsewhere`.  UsageError if the file cannot be read."""
        self._file, self._dialect, self._given = file, dialect, elsewhere
        self._elsewhere: Sequence[Path] = ()
        """The folders and files given, if the tests need something of them."""
        self._test = gathered.read(file, dialect)
        self._kept: Tested | None = None

    def cases(self) -> Sequence[Case]:
        made = [
            Case(test.name, str(self._file), self._file, test.position.line)
            for test in self._test.unit.tests
            if test.word is tree.TestWord.TEST
        ]
        unique = list({case.name: case for case in reversed(made)}.values())[::-1]
        return unique or [Case(COMPILES, str(self._file), self._file, 1)]

    @property
    def path(self) -> Path:
        return self._file

    def files(self) -> Collection[Path]:
        """Return the files on which the tests depend: a change of one of them may change an outcome."""
        found, _ = gathered.with_code(self._test, self._dialect, self._elsewhere)
        rigs = [test.rig for test in self._test.unit.tests if test.rig is not None]
        rigs += [self._test.unit.rig] if self._test.unit.rig is not None else []
        named = {rig.file: named_files(self._file.parent / rig.file) for rig in rigs}
        return {one.path for one in found}.union(*named.values())

    def mistakes(self) -> Sequence[Mistake]:
        """Return the mistakes and notes of the test file, of its code, and of its rigs and their places."""
        try:
            tested = self._compiled()
        except CompileError as wrong:
            return wrong.mistakes
        return [*tested.compiled.notes, *mistakes_of_rigs(self._file, self._test.unit, tested.blocks)]

    def run(self, chosen: Sequence[Case], limits: Limits) -> Iterator[Outcome]:
        try:
            tested = self._present()
        except CompileError as wrong:
            yield from (_not_compiled(case, wrong.mistakes) for case in chosen)
            return
        blocks = {block.test.name: block for block in tested.blocks if block.file == str(self._file)}
        with closing(Rigs(self._file.parent)) as rigs:
            for use, group in groupby([(case, blocks[case.name]) for case in chosen], key=_rig_of):
                tests = list(group)
                if use is None:
                    yield from self._without_rig(tests, tested, limits)
                else:
                    yield from rigs.run(use, tests, tested, limits)

    def _present(self) -> Tested:
        """Return the compiled tests; those that a change of the program leaves as they are, are compiled once."""
        change = switch.present()
        if self._kept is not None and change is not None and not is_in(change, self._kept):
            return self._kept
        tested = self._compiled()
        if change is not None and not is_in(change, tested):
            self._kept = tested
        return tested

    def _without_code(self, files: int, mistakes: Sequence[Mistake]) -> list[Mistake]:
        """Return what to do if nothing beside the test file declares what it names."""
        if files > 1 or self._test.unit.uses or not _NAMES & {one.code for one in mistakes}:
            return []
        what = f"no other file in {self._file.parent} declares what the tests name"
        return [Mistake(1, 1, what, "USES 'file.st'; for code that is elsewhere", file=str(self._file))]

    def _without_rig(
        self, tests: Sequence[tuple[Case, CaseBlock]], tested: Tested, limits: Limits
    ) -> Iterator[Outcome]:
        runner: Runner | None = None
        for case, block in tests:
            if block.test.skip is not None:
                yield Outcome(case, Verdict.SKIPPED, reason=block.test.skip)
                continue
            try:
                runner = runner or Runner(tested, Alone(tested))
            except RigError as wrong:
                yield _not_begun(case, wrong)
                continue
            yield _with_diagram(runner, case, block, limits)

    def _compiled(self) -> Tested:
        try:
            return self._compiled_with(self._elsewhere)
        except CompileError as wrong:
            if self._elsewhere or not self._given or not gathered.has_unknown_names(wrong.mistakes):
                raise
        self._elsewhere = self._given
        return self._compiled_with(self._elsewhere)

    def _compiled_with(self, elsewhere: Sequence[Path]) -> Tested:
        found, mistakes = gathered.with_code(self._test, self._dialect, elsewhere)
        try:
            tested = compile_tests([one.source for one in found], self._dialect)
        except CompileError as wrong:
            raise CompileError([*mistakes, *wrong.mistakes, *self._without_code(len(found), wrong.mistakes)]) from wrong
        if mistakes:
            raise CompileError(mistakes)
        if not tested.blocks:
            raise CompileError([Mistake(1, 1, "there are no tests", "TEST 'name' ... END_TEST", file=str(self._file))])
        return tested


def _rig_of(test: tuple[Case, CaseBlock]) -> tree.RigUse | None:
    """Return the rig that a test runs in; None for one that runs without, or not at all."""
    _, block = test
    return None if block.test.skip is not None else block.rig


def _with_diagram(runner: Runner, case: Case, block: CaseBlock, limits: Limits) -> Outcome:
    """Run a test; if it fails, once more with a record of its signals, as it does the same again."""
    outcome = runner.run(case, block, limits)
    is_done = not outcome.failures or any(failure.kind == TIMEOUT for failure in outcome.failures)
    if is_done or not limits.has_diagrams:
        return outcome
    again = runner.run(case, block, limits, is_recorded=True)
    return again._replace(wall_s=outcome.wall_s, busy_s=outcome.busy_s) if again.verdict is outcome.verdict else outcome


def _not_begun(case: Case, wrong: RigError) -> Outcome:
    return Outcome(case, Verdict.ERROR, (Failure(FAULT, "", wrong.what, "", case.file, case.line, 0),))


def _not_compiled(case: Case, mistakes: Sequence[Mistake]) -> Outcome:
    failures = [
        Failure(MISTAKE, one.expected, one.what, one.hint, Path(one.file), one.line, 0)
        for one in mistakes
        if not one.is_note
    ]
    return Outcome(case, Verdict.ERROR, tuple(failures))
