"""The listing of an application, NAME.doc: what its objects are called in messages.

A message names an object by its compiler ID, which counts the objects of its class from 1 in the order of their
declarations, and a sequence by Snnn (manual lines 9637, 11728 and 12663).
"""

from collections.abc import Iterator, Mapping
from typing import Final

from fieldrig_devices.pam.language.items import Declaration, Item, Program
from fieldrig_devices.pam.runtime import sizes
from fieldrig_devices.pam.runtime.compiler import Compiled

_CLASSES: Final = {"BooleanEquation": "BOOLEAN", "Actions": "ACTIONS", "Routines": "ROUTINES", "Task": "TASK"}


def identifiers(program: Program) -> Mapping[str, Mapping[str, int]]:
    """Return the compiler IDs of all objects, by the class of the object and its name."""
    by_class: dict[str, dict[str, int]] = {}
    for name, kind in _classified(program.items):
        ids = by_class.setdefault(kind, {})
        ids[name] = len(ids) + 1
    return by_class


def _classified(items: tuple[Item, ...] | tuple[Declaration, ...]) -> Iterator[tuple[str, str]]:
    for item in items:
        if isinstance(item, Declaration):
            yield item.name, item.kind
            yield from _classified(item.parts)
        elif type(item).__name__ in _CLASSES:
            yield getattr(item, "name", ""), _CLASSES[type(item).__name__]


def listing(compiled: Compiled) -> str:
    """Return the text of the listing."""
    application, layout = compiled.application, compiled.layout
    size = sizes.application(compiled.program)
    lines = [
        f"APPLICATION {application.name} V {application.version}",
        f"BASIC_PAM_CYCLE {compiled.thirds} ({compiled.thirds / 3:.3f} ms)",
        f"SIZE {size} bytes, {size * 100 / sizes.MOST_BYTES:.1f} % of {sizes.MOST_BYTES}",
    ]
    for kind, ids in identifiers(compiled.program).items():
        lines += ["", f"PAM {kind}", "  ID (hex)  items  name"]
        for name, number in ids.items():
            lines.append(f"{number:>4} ({number:04X}) {layout.counts.get(name, 1):>6}  {name}")
    lines += ["", "PAM SEQUENCES", "  ID    workspace    used  name"]
    for sequence in compiled.code.sequences():
        name = f"{sequence.task}.{sequence.name or 'POWERON'}"
        lines.append(f"  S{sequence.number:03}  {sequence.workspace:>9}  {sequence.used:>6}  {name}")
    return "\n".join(lines) + "\n"
