"""The register tables of a rig as a page in Markdown."""

from collections.abc import Iterable, Iterator, Sequence
from typing import Final

from fieldrig.text.ranges import ranges
from fieldrig_devices.export.register_csv import about_of
from fieldrig_devices.export.register_units import UnitTable
from fieldrig_devices.registers.entries import Bit, Register, each_value, words_of
from fieldrig_devices.registers.table import SPACES, Table, access_of

TITLES: Final = {
    "coils": "Coils", "discrete_inputs": "Discrete inputs", "holding_registers": "Holding registers",
    "input_registers": "Input registers",
}  # fmt: skip
OF_BITS: Final = ("address", "name", "access", "meaning")
OF_REGISTERS: Final = ("address", "name", "type", "unit", "scale", "limits", "access", "meaning")


def page_of(rig: str, tables: Iterable[UnitTable]) -> str:
    """Return the page; `rig` is the name of the rig."""
    lines = [f"# Registers of {rig}", "", "Addresses are as on the wire, from 0."]
    for unit in tables:
        word = "unit" if len(unit.units) == 1 else "units"
        at = f" at {', '.join(unit.buses)}" if unit.buses else ""
        lines += ["", f"## {unit.device}, {word} {ranges(unit.units)}{at}"]
        lines += _table_lines(unit.table)
    return "\n".join(lines) + "\n"


def _table_lines(table: Table) -> Iterator[str]:
    if table.about:
        yield from ("", table.about)
    yield from ("", f"Of several registers the {'high' if table.word_order == 'big' else 'low'} word comes first.")
    for space in SPACES:
        entries = table.entries(space)
        if entries:
            yield from ("", f"### {TITLES[space]}", "")
            are_registers = isinstance(entries[0], Register)
            yield from _markdown(
                OF_REGISTERS if are_registers else OF_BITS, (_row(table, space, entry) for entry in entries)
            )
    if table.fifos:
        yield from ("", "### Queues", "")
        rows = ((str(fifo.address), f"`{fifo.name}`", str(fifo.depth), fifo.about) for fifo in table.fifos)
        yield from _markdown(("address", "name", "most values", "meaning"), rows)
    if table.files:
        yield from ("", "### Files", "")
        files = (
            (str(file.number), f"`{file.name}`", str(file.records), file.access, file.about) for file in table.files
        )
        yield from _markdown(("number", "name", "records", "access", "meaning"), files)


def _row(table: Table, space: str, entry: Bit | Register) -> Sequence[str]:
    last = entry.address + entry.count * words_of(entry) - 1
    place = str(entry.address) if last == entry.address else f"{entry.address} to {last}"
    names = [f"`{name}`" for name, _ in each_value(entry)]
    name = names[0] if len(names) == 1 else f"{names[0]} to {names[-1]}"
    access = access_of(space, entry)
    if not isinstance(entry, Register):
        return place, name, access, about_of(entry)
    return place, name, _type(table, entry), entry.unit, _scale(entry), _limits(entry), access, about_of(entry)


def _limits(entry: Register) -> str:
    match entry.min, entry.max:
        case None, None:
            return ""
        case None, most:
            return f"at most {most:g}"
        case least, None:
            return f"at least {least:g}"
        case least, most:
            return f"{least:g} to {most:g}"


def _type(table: Table, entry: Register) -> str:
    swapped = [
        f"{order} {part} first"
        for part, order, usual in (
            ("word", entry.word_order, table.word_order),
            ("byte", entry.byte_order, table.byte_order),
        )
        if order is not None and order != usual
    ]
    return ", ".join((entry.type, *swapped))


def _scale(entry: Register) -> str:
    parts = [] if entry.scale == 1 else [f"{entry.scale:g}"]
    parts += [f"`{entry.factor_from}`"] if entry.factor_from else []
    parts += [f"10^`{entry.exponent_from}`"] if entry.exponent_from else []
    return " x ".join(parts) + (f" {entry.offset:+g}" if entry.offset else "")


def _markdown(columns: Sequence[str], rows: Iterable[Sequence[str]]) -> Iterator[str]:
    yield f"| {' | '.join(columns)} |"
    yield f"|{'---|' * len(columns)}"
    yield from (f"| {' | '.join(_cell(cell) for cell in row)} |" for row in rows)


def _cell(text: str) -> str:
    return " ".join(text.replace("|", "\\|").split())
