"""Settings in a YAML file of their own, such as a register table or a name plate.

    table = load_settings(Path("pump.yaml"), Table, conflicts)

A rig file is read by the same steps: `yaml_source` turns text into plain values with the line of each key, `validated`
checks them against a `Settings` model, and every mistake is reported with file, line, key, and what was expected.
"""

import json
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any, TypeVar

from pydantic import ValidationError

from fieldrig.config.wording import explain
from fieldrig.config.yaml_source import Source, key_text, read_file
from fieldrig.errors import ConfigError, Mistake
from fieldrig.settings import Settings, WrongKey, WrongSettingsError

S = TypeVar("S", bound=Settings)


def load_settings(path: Path, model: type[S], conflicts: Callable[[S], Iterable[WrongKey]] = lambda settings: ()) -> S:
    """Return the settings in a file.  ConfigError with every mistake.

    `conflicts` yields what is wrong in settings that the model accepts, such as entries that exclude each other.  Files
    that the settings name are relative to the folder of this one.
    """
    return settings_of(read_file(path), model, conflicts)


def settings_of(
    source: Source, model: type[S], conflicts: Callable[[S], Iterable[WrongKey]] = lambda settings: ()
) -> S:
    """Return the same from data that was read or made before.  An empty file is a mapping without keys."""
    if source.mistakes:
        raise ConfigError(source.mistakes)
    try:
        settings = validated(model, {} if source.data is None else source.data, source.folders)
        clashes = tuple(conflicts(settings))
        if clashes:
            raise WrongSettingsError(clashes)
    except WrongSettingsError as cause:
        mistakes = [
            Mistake(*source.mark(wrong.path), key_text(wrong.path), wrong.what, wrong.remedy) for wrong in cause.wrong
        ]
        raise ConfigError(mistakes) from cause
    return settings


def validated(model: type[S], data: Any, folders: Sequence[Path] = (), other_keys: tuple[str, ...] = ()) -> S:
    """Return plain values as settings.  WrongSettingsError with every mistake.

    The rules are pydantic's for JSON: strict, but a list may become a tuple, and a text an enum or a path.  Paths are
    looked up in `folders`; `other_keys` are those that the mapping may have beside the model's, for messages.
    """
    context = {"folder": folders[0], "folders": folders} if folders else {}
    try:
        return model.model_validate_json(json.dumps(data), context=context)
    except ValidationError as cause:
        raise WrongSettingsError(explain(cause, data, model, other_keys)) from cause
    except OSError as cause:
        raise WrongSettingsError([WrongKey((), f"a file that it names cannot be read: {cause}")]) from cause
