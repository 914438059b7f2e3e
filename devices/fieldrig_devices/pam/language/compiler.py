"""Compile the text of an application to a checked tree, in one call."""

from fieldrig_devices.languages.mistakes import Mistake
from fieldrig_devices.pam.language.check import check
from fieldrig_devices.pam.language.items import Program
from fieldrig_devices.pam.language.parser import parse
from fieldrig_devices.pam.language.preprocessor import Reader, no_files


def checked(
    text: str, file: str, read: Reader = no_files, *, ignores_case: bool = False
) -> tuple[Program, list[Mistake]]:
    """Return the tree of an application, and all mistakes and notes in the order of the text.

    Names and types are checked only if the text could be read, because otherwise one mistake would be reported in many
    places.  `read` returns the text of an included file.
    """
    program, mistakes = parse(text, file, read, ignores_case=ignores_case)
    if any(not mistake.is_note for mistake in mistakes):
        return program, mistakes
    all_mistakes = [*mistakes, *check(program, file)]
    return program, sorted(all_mistakes, key=lambda mistake: (mistake.file, mistake.line, mistake.column))
