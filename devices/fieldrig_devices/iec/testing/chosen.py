"""The tests that a person has chosen: by paths, by names, by patterns."""

from collections.abc import Iterator, Sequence
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Final

from fieldrig_devices.iec.dialect import Dialect
from fieldrig_devices.iec.imports.plcproj import SUFFIX
from fieldrig_devices.iec.testing import by_pytest, gathered
from fieldrig_devices.iec.testing.blocks import BlockSource
from fieldrig_devices.iec.testing.by_pytest import PytestSource
from fieldrig_devices.iec.testing.case import Case, Source
from fieldrig_devices.iec.testing.suites import sources_in

_WILD: Final = frozenset("*?[")
_AND: Final = "::"


def split(path: str) -> tuple[Path, str]:
    """Return the path and the name in `pid_test.st::holds the output`; the name is empty for all tests."""
    file, mark, name = path.partition(_AND)
    return Path(file), name if mark else ""


def sources_of(paths: Sequence[Path], dialect: Dialect) -> list[Source]:
    """Return a source for each kind of tests in each place.  UsageError for a file that cannot be read."""
    in_python = [PytestSource(path) for path in dict.fromkeys(paths) if _is_python(path)]
    others = [path for path in paths if not _is_python(path)]
    texts = _texts(others)
    blocks = [BlockSource(file, dialect, texts) for file in dict.fromkeys(gathered.test_files(texts))]
    return [*blocks, *(source for path in others for source in sources_in(path)), *in_python]


def _is_python(path: Path) -> bool:
    return path.suffix.casefold() == by_pytest.SUFFIX and path.is_file()


def _texts(paths: Sequence[Path]) -> list[Path]:
    """Return the paths that may have TEST blocks: the list of files of a project has none."""
    return [path for path in paths if path.suffix.casefold() != SUFFIX]


def is_chosen(case: Case, names: Sequence[tuple[Path, str]], patterns: Sequence[str]) -> bool:
    """True for a test that a path names, and that fits at least one pattern if there are any."""
    return _is_named(case, names) and (not patterns or any(fits(str(case), pattern) for pattern in patterns))


def unmet(
    cases: Sequence[Case], names: Sequence[tuple[Path, str]], patterns: Sequence[str]
) -> Iterator[tuple[str, list[str]]]:
    """Yield each name and pattern that fits no test, and the names of the tests that it could have meant."""
    for path, name in names:
        inside = [case.name for case in cases if _is_named(case, [(path, "")])]
        if name and not any(_is_named(case, [(path, name)]) for case in cases):
            yield name, inside
    for pattern in patterns:
        if not any(fits(str(case), pattern) for case in cases):
            yield pattern, [case.name for case in cases]


def _is_named(case: Case, names: Sequence[tuple[Path, str]]) -> bool:
    for path, name in names:
        is_inside = path.suffix.casefold() == SUFFIX or _is_in(case.file, path)
        if is_inside and (not name or fits(case.name, name, is_whole=True)):
            return True
    return False


def _is_in(file: Path, path: Path) -> bool:
    """True for a file at or below a path; one of the two may be absolute, or lead over a link or `..`."""
    if file == path or path in file.parents:
        return True
    file, path = file.resolve(), path.resolve()
    return file == path or path in file.parents


def fits(text: str, pattern: str, *, is_whole: bool = False) -> bool:
    """True if a pattern with *, ? or [] matches the text, or a plain one is in it; the case does not matter."""
    text, pattern = text.casefold(), pattern.casefold()
    if _WILD & set(pattern):
        return fnmatchcase(text, pattern if is_whole else f"*{pattern}*") or text == pattern
    return text == pattern if is_whole else pattern in text
