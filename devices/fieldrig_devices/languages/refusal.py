"""The refusal of a program that a rig file names, with every mistake in it."""

from collections.abc import Mapping, Sequence

from fieldrig.errors import ConfigError
from fieldrig.errors import Mistake as Wrong
from fieldrig_devices.languages.mistakes import CompileError, Mistake


def refused(wrong: CompileError, paths: Mapping[str, str]) -> ConfigError:
    """Return the mistakes of a program that a rig file names; `paths` has the path of each file by its name."""
    return ConfigError(_mistakes(paths, [mistake for mistake in wrong.mistakes if not mistake.is_note]))


def _mistakes(paths: Mapping[str, str], mistakes: Sequence[Mistake]) -> list[Wrong]:
    wrong = []
    for mistake in mistakes:
        file = paths.get(mistake.file, mistake.file)
        expected = f"expected {mistake.expected}" if mistake.expected else ""
        remedy = "\n    ".join(part for part in (expected, mistake.hint) if part)
        wrong.append(Wrong(file, mistake.line, "program", mistake.what, remedy, mistake.column))
    return wrong
