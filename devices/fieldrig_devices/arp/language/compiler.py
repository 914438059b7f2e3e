"""The ARP compiler: it turns text into executable form and reports all mistakes at once."""

from collections.abc import Iterable
from dataclasses import dataclass

from fieldrig_devices.arp.language import parser
from fieldrig_devices.arp.language.check import check, check_equs
from fieldrig_devices.arp.language.lower import Lowered, lower
from fieldrig_devices.arp.language.names import Symbols, resolve
from fieldrig_devices.arp.language.tree import Program
from fieldrig_devices.languages.mistakes import CompileError, Mistake


@dataclass(frozen=True, slots=True)
class Compiled:
    program: Program
    """The resolved tree; the only names in it are labels and routines."""
    symbols: Symbols
    lowered: Lowered
    notes: tuple[Mistake, ...]

    @property
    def main(self) -> str:
        return self.program.routines[0].name


def compile_text(text: str) -> Compiled:
    """Compile a program.  Raises CompileError with every mistake if the program is wrong."""
    return _compile(*parser.parse(text))


def compile_lines(numbered: Iterable[tuple[int, str]], longest: int) -> Compiled:
    """Compile lines that carry their own numbers, each of at most `longest` characters."""
    return _compile(*parser.parse_lines(numbered, longest))


def _compile(read: Program, mistakes: list[Mistake]) -> Compiled:
    program, symbols, unresolved = resolve(read)
    all_mistakes = sorted({*mistakes, *unresolved, *check(program, symbols), *check_equs(read)})
    if any(not mistake.is_note for mistake in all_mistakes):
        raise CompileError(all_mistakes)
    return Compiled(program, symbols, lower(program), tuple(all_mistakes))
