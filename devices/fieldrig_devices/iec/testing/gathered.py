"""The test files of a path, and the code beside each of them that its tests need.

A test file names its code by USES, or has it in its own folder, or in the folders that are given with it.  Only the
files are taken whose declarations the tests reach, so what does not compile elsewhere in a folder does not matter.
"""

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import takewhile
from pathlib import Path
from typing import Final

from fieldrig.errors import UsageError
from fieldrig_devices.iec import tree
from fieldrig_devices.iec.dialect import Dialect
from fieldrig_devices.iec.imports import is_foreign, read_source
from fieldrig_devices.iec.library.selection import words
from fieldrig_devices.iec.source_texts import SUFFIXES, files_in, read_text
from fieldrig_devices.languages.mistakes import Mistake
from fieldrig_devices.languages.source_file import SourceFile

_BEGIN: Final = r"TEST(?:\s*['\"]|_(?:PROGRAM|FUNCTION_BLOCK)\s+[A-Za-z_])"
"""The words with which a test begins, also those of truST."""
_HAS_TESTS: Final = re.compile(rf"(?:^|[\s;)]){_BEGIN}", re.IGNORECASE)
_PART: Final = re.compile(
    rf"\(\*.*?\*\)|//[^\n]*|(?P<test>(?<!\w){_BEGIN})|'(?:\$.|[^$'\n])*'|\"(?:\$.|[^$\"\n])*\"",
    re.DOTALL | re.IGNORECASE,
)
"""A comment, a text or the word: one in a comment or in a text, such as `'Error in test'`, begins no test."""
_UNKNOWN: Final = " is not declared"
_RUNS_TASKS: Final = frozenset({"run_for", "assert_within", "assert_never", "assert_stays", "assert_until"})
"""Words of tests that need the tasks of the program, and so its configuration."""


@dataclass(frozen=True, slots=True, eq=False)
class Read:
    """A source file with its tree."""

    path: Path
    text: str
    unit: tree.Unit
    mistakes: tuple[Mistake, ...]

    @property
    def source(self) -> SourceFile:
        return SourceFile(str(self.path), self.text)


def has_tests(path: Path) -> bool:
    """True if there are TEST blocks in a file; it may have mistakes."""
    text = read_text(path)
    return _HAS_TESTS.search(text) is not None and any(part["test"] for part in _PART.finditer(text))


def test_files(paths: Sequence[Path]) -> list[Path]:
    """Return the files with TEST blocks.  UsageError for a file that cannot be read.

    In a folder, a document of another kind has none, though a report of earlier tests shows their text.
    """
    return [
        file
        for path in paths
        for file in files_in(path)
        if has_tests(file) and (file == path or not _is_foreign(read_text(file)))
    ]


def read(path: Path, dialect: Dialect) -> Read:
    """Read a source file, again only if it has changed.  UsageError if it cannot be read."""
    return _read(path, read_text(path), dialect)


@lru_cache(maxsize=2_000)
def _read(path: Path, text: str, dialect: Dialect) -> Read:
    unit, mistakes = read_source(str(path), text, dialect)
    return Read(path, text, unit, tuple(mistakes))


def with_code(test: Read, dialect: Dialect, elsewhere: Sequence[Path] = ()) -> tuple[list[Read], list[Mistake]]:
    """Return a test file with the files of its code, and what is wrong with the names of these.

    What no file beside the test declares is looked for in the folders and files of `elsewhere`.
    """
    if not test.unit.uses:
        return [test, *_reached(test, dialect, elsewhere)], []
    found, mistakes = [test], []
    for use in test.unit.uses:
        path = test.path.parent / use.file
        inside = [file for file in files_in(path) if file != test.path] if path.exists() else []
        try:
            found += [read(file, dialect) for file in inside if path.is_file() or not has_tests(file)]
        except UsageError as wrong:
            mistakes.append(Mistake(*use.position, wrong.what, wrong.remedy, file=str(test.path)))
        if not inside:
            what = f"there is no {use.file!r} beside this file"
            mistakes.append(Mistake(*use.position, what, "a source file, or a folder with some", file=str(test.path)))
    return list(dict.fromkeys(found)), mistakes


def with_files_to_give(mistakes: Sequence[Mistake], files: Sequence[Path], dialect: Dialect) -> list[Mistake]:
    """Return the mistakes of a program; one for a name that a file beside it declares has that file as its hint."""
    if not has_unknown_names(mistakes):
        return list(mistakes)
    given = {path.resolve() for path in files}
    folders = [folder for folder in {path.parent: None for path in files} if folder.is_dir()]
    beside = (other for folder in folders for other in sorted(folder.iterdir()))
    declared: dict[str, Path] = {}
    for other in beside:
        if other.suffix.lower() in SUFFIXES and other.is_file() and other.resolve() not in given:
            with suppress(UsageError):  # it is no text
                declared |= dict.fromkeys(_names(read(other, dialect)), other)
    return [_with_file(mistake, declared) for mistake in mistakes]


def _with_file(mistake: Mistake, declared: Mapping[str, Path]) -> Mistake:
    name = mistake.what.removesuffix(_UNKNOWN).rpartition(" ")[2].casefold()
    if not mistake.what.endswith(_UNKNOWN) or name not in declared:
        return mistake
    return replace(mistake, expected="", hint=f"{declared[name].name} beside it declares it: give this file too")


def has_unknown_names(mistakes: Sequence[Mistake]) -> bool:
    """True if something is not declared in the files of a program."""
    return any(mistake.what.endswith(_UNKNOWN) for mistake in mistakes)


def _without_tests(paths: Iterable[Path], dialect: Dialect) -> Iterator[Read]:
    """Yield the source files among some paths that have no tests."""
    for path in paths:
        if path.suffix.lower() not in SUFFIXES or not path.is_file():
            continue
        try:
            if not has_tests(path) and not _is_foreign(read_text(path)):
                yield read(path, dialect)
        except UsageError:  # it is no text, and no test reaches it
            continue


@lru_cache(maxsize=2_000)
def _is_foreign(text: str) -> bool:
    return is_foreign(text)


def _far(test: Path, elsewhere: Sequence[Path]) -> list[Path]:
    """Return the source files elsewhere, those in the folders nearest to a test first."""
    own = test.resolve().parent
    inside = dict.fromkeys(file.resolve() for path in elsewhere for file in files_in(path))
    return sorted((file for file in inside if file.parent != own), key=lambda file: (-_shared(file, own), file))


def _shared(file: Path, folder: Path) -> int:
    """Return the number of folders that a file and a folder have in common."""
    return sum(1 for _ in takewhile(lambda pair: pair[0] == pair[1], zip(file.parts, folder.parts, strict=False)))


def _reached(test: Read, dialect: Dialect, elsewhere: Sequence[Path]) -> list[Read]:
    """Return the files beside a test or elsewhere that declare what it names, and what these name in turn."""
    beside = list(_without_tests((path for path in sorted(test.path.parent.iterdir()) if path != test.path), dialect))
    declared: dict[str, list[Read]] = {}
    for file in beside:
        for name in _names(file):
            declared.setdefault(name, []).append(file)
    for file in _without_tests(_far(test.path, elsewhere), dialect):
        for name in _names(file):
            declared.setdefault(name, [file])
    known, open_words = set(_names(test)), {*_words(test), *_words_of_tests(test.unit)}
    reached: list[Read] = []
    if _words_of_tests(test.unit, is_alone=True) & _RUNS_TASKS:
        reached = [file for file in beside if _is_configuration(file.unit)]
        open_words |= {word for file in reached for word in _words(file)}
    while new := open_words & declared.keys() - known:
        known |= new
        added = [file for name in sorted(new) for file in _chosen(declared[name], reached, test.path)]
        added = list(dict.fromkeys(added))
        reached += added
        open_words = {word for file in added for word in _words(file)}
    return sorted(reached, key=lambda file: file.path)


def _words_of_tests(unit: tree.Unit, *, is_alone: bool = False) -> set[str]:
    """Return the words of the tests of a file, without their own variables; `is_alone`: of those without a rig."""
    shared = [part for part in unit.tests if part.word is not tree.TestWord.TEST]
    tests = [part for part in unit.tests if part.word is tree.TestWord.TEST]
    chosen = [part for part in tests if not (is_alone and (part.rig or unit.rig))]
    found: set[str] = set()
    for part in [*chosen, *(shared if chosen else [])]:
        own = {one.name.casefold() for each in (part, *shared) for block in each.blocks for one in block.variables}
        found |= set(words(replace(part, name="", skip=None))) - own  # its title is for people
    return found


@lru_cache(maxsize=2_000)
def _words(file: Read) -> frozenset[str]:
    """Return the words of the declarations of a file."""
    return frozenset(word for part in file.unit.declarations for word in words(part))


def _chosen(files: Sequence[Read], reached: Sequence[Read], test: Path) -> list[Read]:
    """Return the new files for a name: if several declare it, the one that the test is named after."""
    if any(file in reached for file in files):
        return []
    named = [file for file in files if file.path.stem.lower() == _subject(test)]
    return named or list(files)


def _subject(test: Path) -> str:
    """Return the name of the file that a test file is named after: `pid` for `pid_test.st` and `test_pid.st`."""
    return re.sub(r"^tests?_|_?tests?$", "", test.stem.lower())


def _is_configuration(unit: tree.Unit) -> bool:
    return any(isinstance(declared, tree.Configuration) for declared in unit.declarations)


@lru_cache(maxsize=2_000)
def _names(file: Read) -> frozenset[str]:
    """Return the names that a file declares for all others."""
    return frozenset(_declared(file.unit))


def _declared(unit: tree.Unit) -> Iterator[str]:
    for declared in unit.declarations:
        match declared:
            case tree.Pou(name=name) | tree.Interface(name=name):
                yield name.casefold()
            case tree.TypeDeclaration(name=name, type=spec):
                yield name.casefold()
                if isinstance(spec, tree.EnumSpec):
                    yield from (value.name.casefold() for value in spec.values)
            case tree.Variables(variables=variables, name=name):
                yield from (variable.name.casefold() for variable in variables)
                if name:
                    yield name.casefold()
            case tree.Configuration(blocks=blocks):
                yield from (variable.name.casefold() for block in blocks for variable in block.variables)
