"""Compiling a stored program for the controller that it is stored on.

Source: PacDrive manual 6015-6041 (digest PD-310 to PD-318): RETAIN variables have to fit into the memory that the
controller has for them.
"""

from collections.abc import Sequence

from fieldrig_devices.iec.compiler import Compiled, SourceFile, compile_project
from fieldrig_devices.iec.dialect import DIALECTS
from fieldrig_devices.iec.host import Host
from fieldrig_devices.languages.mistakes import CompileError, Mistake
from fieldrig_devices.max4.plc.container import Container
from fieldrig_devices.max4.plc.retain import RetainMap, leaves_of
from fieldrig_devices.max4.storage.retain import SIZES, RetainKind


def compile_container(
    container: Container, host: Host, retain: RetainKind, previous: Compiled | None = None
) -> Compiled:
    """Compile the sources; CompileError with all mistakes.  `previous` is the running program for an online change."""
    files = [SourceFile(source.name, source.text) for source in container.files]
    dialect = DIALECTS.get(container.dialect)
    if dialect is None:
        known = ", ".join(DIALECTS)
        raise CompileError([Mistake(1, 1, f"the dialect {container.dialect!r} is not known", known)])
    compiled = compile_project(files, host, dialect, previous=previous)
    _check_retain(compiled, SIZES[retain])
    return compiled


def _check_retain(compiled: Compiled, size: int) -> None:
    leaves = leaves_of(compiled.program)
    needed = RetainMap(leaves).size
    if needed <= size:
        return
    at = 0
    for leaf in leaves:
        at += leaf.size
        if at > size:
            break
    source = leaf.variable
    assert source is not None, "a leaf of a program belongs to a variable"
    raise CompileError(
        [
            Mistake(
                source.place.line,
                source.place.column,
                f"the RETAIN variables need {needed} bytes, and {leaf.path} is the first that has no room",
                f"at most {size} bytes",
                file=source.file,
                hint="Declare fewer variables as RETAIN, or give the controller more memory: "
                "`retain: ups` has 64 kB, `retain: pn4` 101 kB.",
            )
        ]
    )


def text_of(mistakes: Sequence[Mistake]) -> str:
    """The mistakes, one a line, without notes."""
    return "\n".join(str(mistake) for mistake in mistakes if not mistake.is_note)
