"""The problems of a file, for an editor: rig files and programs of all languages in one form.

A program is judged as it is used.  The rig files that name it are searched in its folder and in those above it, up to
the folder that the editor has open.  Without one, a program in ST has the files beside it whose declarations it
reaches, as a test has.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

from fieldrig.cli.common import reading
from fieldrig.cli.rigfile import look_at
from fieldrig.errors import Mistake as Wrong
from fieldrig_devices.arp.language.files import system_of
from fieldrig_devices.editor.rigs import YAML, is_rig, rigs_with
from fieldrig_devices.iec.commands.sources import dialect_named
from fieldrig_devices.languages.mistakes import CompileError, Mistake


@dataclass(frozen=True, slots=True, order=True)
class Problem:
    """One thing that is wrong, or noteworthy."""

    file: str
    line: int
    column: int
    severity: str
    """`error`, `warning` or `note`."""
    message: str


def problems_of(file: Path, root: Path, dialect: str) -> list[Problem]:
    """Return what is wrong with a file, and with those that belong to it.

    UsageError if it cannot be read, BadParameter for an unknown dialect.
    """
    with reading(file):
        file.open("rb").close()
    if file.suffix.lower() in YAML:
        return sorted(set(_of_rig(file))) if is_rig(file) else []
    rigs = [] if _has_tests(file) else list(rigs_with(file, root))
    if rigs:
        return sorted({problem for rig in rigs for problem in _of_rig(rig)})
    return sorted({_of_program(mistake, file) for mistake in _mistakes(file, dialect)})


# ---- rig files


def _of_rig(file: Path) -> Iterator[Problem]:
    _, mistakes, doubts = look_at(file, ())
    for severity, found in (("error", mistakes), ("warning", doubts)):
        for one in found:
            yield Problem(str(Path(one.file).absolute()), one.line or 1, one.column or 1, severity, _words(one))


def _words(wrong: Wrong) -> str:
    head = wrong.what if wrong.column is not None else ": ".join(part for part in (wrong.key, wrong.what) if part)
    remedy = (line.strip() for line in wrong.remedy.splitlines())
    return "\n".join((head, *remedy))


# ---- programs


def _of_program(mistake: Mistake, file: Path) -> Problem:
    severity = "note" if mistake.is_note else "error"
    expected = f"{mistake.what}; expected {mistake.expected}" if mistake.expected else mistake.what
    message = f"{expected}\n{mistake.hint}" if mistake.hint else expected
    place = Path(mistake.file or file).absolute()
    return Problem(str(place), max(mistake.line, 1), max(mistake.column, 1), severity, message)


def _mistakes(file: Path, dialect: str) -> Iterable[Mistake]:
    if file.suffix.lower() == ".pam":
        return _of_pam(file)
    if system_of(file) is not None:
        return _of_arp(file)
    return _of_iec(file, dialect)


def _of_pam(file: Path) -> Iterable[Mistake]:
    from fieldrig_devices.pam.commands.checking import looked_through

    return looked_through(file, ignores_case=False)[1]


def _of_arp(file: Path) -> Iterable[Mistake]:
    from fieldrig_devices.arp.commands.checking import looked_through

    return looked_through(file)


def _has_tests(file: Path) -> bool:
    from fieldrig_devices.iec.source_texts import SUFFIXES
    from fieldrig_devices.iec.testing.gathered import has_tests

    return file.suffix.lower() in SUFFIXES and has_tests(file)


def _of_iec(file: Path, dialect: str) -> Iterable[Mistake]:
    from fieldrig.clock import VirtualClock
    from fieldrig_devices.iec.compiler import compile_project
    from fieldrig_devices.iec.standalone import StandaloneHost
    from fieldrig_devices.iec.testing.blocks import BlockSource
    from fieldrig_devices.iec.testing.gathered import read, with_code

    rules = dialect_named(dialect)
    if _has_tests(file):
        return BlockSource(file, rules).mistakes()
    found, mistakes = with_code(read(file, rules), rules)
    try:
        compiled = compile_project([one.source for one in found], StandaloneHost(VirtualClock()), rules)
    except CompileError as wrong:
        return [*mistakes, *wrong.mistakes]
    return [*mistakes, *compiled.notes]
