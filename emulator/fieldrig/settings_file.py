"""Reads a YAML file of one `Settings` model, such as a name plate or a register table, with all its mistakes."""

from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any, TypeVar

from pydantic import ValidationError

from fieldrig.errors import ConfigError, Mistake
from fieldrig.settings import Settings
from fieldrig.wording import explain
from fieldrig.yaml_source import KeyPath, Source, key_text, read

M = TypeVar("M", bound=Settings)
Finding = tuple[KeyPath, str, str]
"""Where in the file, what is wrong, and what was expected."""


def _nothing(_model: Any) -> Iterable[Finding]:
    return ()


def load_settings(path: Path, model: type[M], kind: str, check: Callable[[M], Iterable[Finding]] = _nothing) -> M:
    """Return the model that the file holds.  ConfigError with every mistake in the file, each with its line.

    `kind` says in a message what the file is, such as "a register table".  `check` finds mistakes in a model whose
    values are right one by one.
    """
    try:
        text = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as cause:
        raise ConfigError([Mistake(str(path), None, "", f"it can't be read: {cause}", f"name {kind}")]) from cause
    source = read(text, str(path))
    if source.mistakes:
        raise ConfigError(source.mistakes)
    return validated(source, str(path), model, check)


def validated(source: Source, file: str, model: type[M], check: Callable[[M], Iterable[Finding]] = _nothing) -> M:
    """Return the model that `source` holds.  ConfigError with every mistake, each with its line in `file`."""
    values: Any = source.data if source.data is not None else {}
    try:
        found = model.model_validate(values)
    except ValidationError as cause:
        findings = [(finding.path, finding.what, finding.remedy) for finding in explain(cause, values, model)]
        raise ConfigError(_mistakes(source, file, findings)) from cause
    mistakes = _mistakes(source, file, check(found))
    if mistakes:
        raise ConfigError(mistakes)
    return found


def _mistakes(source: Source, file: str, findings: Iterable[Finding]) -> list[Mistake]:
    return [Mistake(file, source.mark(path).line, key_text(path), what, remedy) for path, what, remedy in findings]
