"""Settings in a YAML file of their own, such as a register table or a name plate.

table = load_settings(Path("pump.yaml"), Table, conflicts)
"""

from collections.abc import Callable, Iterable
from pathlib import Path
from typing import TypeVar

from pydantic import ValidationError

from fieldrig.errors import ConfigError, Mistake
from fieldrig.settings import Settings, WrongKey
from fieldrig.wording import explain
from fieldrig.yaml_source import Source, key_text, read

S = TypeVar("S", bound=Settings)


def load_settings(path: Path, model: type[S], conflicts: Callable[[S], Iterable[WrongKey]] = lambda settings: ()) -> S:
    """Return the settings in a file.  ConfigError with every mistake, each with its line.

    `conflicts` yields what is wrong in settings that the model accepts, such as entries that exclude each other.
    """
    file = str(path)
    try:
        text = path.read_text(encoding="utf-8")
    except (OSError, ValueError) as cause:
        raise ConfigError([Mistake(file, None, "", f"it can't be read: {cause}", "")]) from cause
    return settings_of(read(text, file), model, conflicts, file)


def settings_of(
    source: Source,
    model: type[S],
    conflicts: Callable[[S], Iterable[WrongKey]] = lambda settings: (),
    file: str = "",
) -> S:
    """Return the same from data that was read or made before.  An empty file is a mapping without keys."""
    if source.mistakes:
        raise ConfigError(source.mistakes)
    values = {} if source.data is None else source.data
    try:
        settings = model.model_validate(values)
    except ValidationError as cause:
        found = [WrongKey(finding.path, finding.what, finding.remedy) for finding in explain(cause, values, model)]
        raise ConfigError(_mistakes(source, file, found)) from cause
    mistakes = _mistakes(source, file, conflicts(settings))
    if mistakes:
        raise ConfigError(mistakes)
    return settings


def _mistakes(source: Source, file: str, found: Iterable[WrongKey]) -> list[Mistake]:
    return [Mistake(file, source.mark(key.path).line, key_text(key.path), key.what, key.remedy) for key in found]
