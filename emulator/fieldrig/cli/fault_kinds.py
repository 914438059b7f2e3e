"""The list of all faults, by the kinds of buses and devices that take them."""

from collections.abc import Iterable, Mapping
from typing import Any, Final, NamedTuple

import typer

from fieldrig.cli.common import echo_json, echo_table

COMMON: Final = frozenset({"what", "start_ms", "duration_ms", "when"})
REQUIRED: Final = "="


class FaultKind(NamedTuple):
    """A fault as the list has it."""

    what: str
    effect: str
    keys: tuple[str, ...]
    """Its keys beside those that all have; one that is required ends in `=`."""


def show_kinds(kind: str | None, as_json: bool) -> None:
    """Print the faults of all installed kinds, or of one."""
    import sys
    from pathlib import Path

    sys.path.insert(0, str(Path.cwd()))
    found = _of_all() if kind is None else {kind: _of(kind)}
    if as_json:
        echo_json({name: {each.what: list(each.keys) for each in faults} for name, faults in found.items()})
        return
    groups: dict[tuple[FaultKind, ...], list[str]] = {}
    for name, faults in found.items():
        groups.setdefault(faults, []).append(name)
    typer.echo("Each takes when=, start_ms= and duration_ms= as well.")
    for faults, names in groups.items():
        typer.echo(f"\n{', '.join(names)}:")
        if faults:
            echo_table(("what", "effect", "keys"), [(what, effect, " ".join(keys)) for what, effect, keys in faults])
        else:
            typer.echo("none")
        for name in names:
            if reason := _reason(name):
                typer.echo(f"{name}: {reason}")


def _of_all() -> dict[str, tuple[FaultKind, ...]]:
    from fieldrig.config.kinds import BUSES, DEVICES, installed

    return {name: _of(name) for group in (BUSES, DEVICES) for name in installed(group)}


def _of(kind: str) -> tuple[FaultKind, ...]:
    """Return the faults of a kind.  BadParameter if there is no such kind."""
    from fieldrig.device import Device
    from fieldrig.faults.power import models_of_device

    cls = _class_of(kind)
    return tuple(_all_of(models_of_device(cls) if issubclass(cls, Device) else cls.fault_models))


def _class_of(kind: str) -> Any:
    from fieldrig.config import kinds
    from fieldrig.errors import RigError
    from fieldrig.text.nearest import closest

    try:
        return kinds.find_bus(kind)
    except RigError:
        try:
            return kinds.find_device(kind)
        except RigError as wrong:
            every = [*kinds.installed(kinds.BUSES), *kinds.installed(kinds.DEVICES)]
            raise typer.BadParameter(
                f"{wrong.what}; {wrong.remedy if ':' in kind else closest(kind, every)}"
            ) from wrong


def _reason(kind: str) -> str:
    return str(_class_of(kind).no_faults)


def _all_of(models: Mapping[str, Any]) -> Iterable[FaultKind]:
    from fieldrig.faults.faults import keys_of

    for what, model in models.items():
        fields = {key: model.model_fields[key] for key in keys_of(model) if key not in COMMON}
        keys = tuple(f"{key}{REQUIRED}" if field.is_required() else key for key, field in fields.items())
        yield FaultKind(what, (model.__doc__ or "").strip().partition("\n")[0], keys)
