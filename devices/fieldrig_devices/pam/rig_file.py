"""A rig file for an application: the PAM, and the nodes that its declarations need."""

from collections.abc import Iterator, Mapping
from typing import Final

from fieldrig_devices.pam.declared_nodes import declarations, declared_nodes
from fieldrig_devices.pam.language.items import Program
from fieldrig_devices.pam.objects.declared import Declared
from fieldrig_devices.pamring.frames import NodeType
from fieldrig_devices.smart_io.addresses import exists, place_of

_ON_MODULES: Final = ("BINARY_INPUT", "BINARY_OUTPUT", "DIGITAL_INPUT", "DIGITAL_OUTPUT", "COUNTER_INPUT", "KEY_INPUT")
_ON_KEYBOARD: Final = ("LED_OUTPUT", "D7SEG_OUTPUT", "KEY_INPUT")


def rig_file(program: Program, application: str, *, is_virtual: bool, ignores_case: bool = False) -> str:
    """Return the text of a rig file that runs an application, whose file is named relative to the rig file.

    A Smart-IO gets the modules and the keyboard that the application uses; an ST1 has the defaults of its kind.
    """
    kind = "virtual" if is_virtual else "shm"
    wires = "virtual" if is_virtual else "hub"
    names = [name for _, names in _devices(program) for name in names]
    after = "" if is_virtual else f"\n    after: [{', '.join(names)}]"
    readings = "\n    programs: {ignores_case: true}" if ignores_case else ""
    head = f"""\
# The nodes that {application} declares, on the ring of a PAM.
time: {"virtual" if is_virtual else "real"}
buses:
  pamring: {{kind: pamring.{kind}}}
  wires: {{kind: wires.{wires}}}
devices:
  pam:
    kind: pam{after}
    links: {{ring: pamring, wires: wires}}
    application: {application}{readings}
"""
    return head + "".join(text for text, _ in _devices(program))


def _devices(program: Program) -> Iterator[tuple[str, list[str]]]:
    """Yield the entries of each NODE, with the names of its devices."""
    uses = _uses(program)
    nodes = [declaration for declaration in declarations(program) if declaration.kind == "NODE"]
    for declared, node in zip(nodes, declared_nodes(program), strict=True):
        base = declared.name.lower()
        names = [base] if node.count == 1 else [f"{base}_{number}" for number in range(1, node.count + 1)]
        own = "" if node.node_type is NodeType.ST1 else _smart_io_keys(uses.get(declared.name, []))
        kind = "st1" if node.node_type is NodeType.ST1 else "smart_io"
        yield (
            "".join(
                f"  {name}: {{kind: {kind}, ring_address: {address}, links: {{ring: pamring, wires: wires}}{own}}}\n"
                for name, address in zip(names, node.addresses, strict=True)
            ),
            names,
        )


def _uses(program: Program) -> Mapping[str, list[Declared]]:
    """Return the inputs and outputs by their nodes."""
    uses: dict[str, list[Declared]] = {}
    for declared in declarations(program):
        node = declared.reference("NODE")
        if node:
            uses.setdefault(node, []).append(declared)
    return uses


def _smart_io_keys(uses: list[Declared]) -> str:
    on_modules = [
        use for use in uses if use.kind in _ON_MODULES and not (use.kind == "KEY_INPUT" and not _is_on_input(use))
    ]
    addresses = [use.integer("ADDRESS") for use in on_modules]
    modules = sorted({place_of(address)[0] for address in addresses if exists(address)})
    has_keyboard = any(use.kind in _ON_KEYBOARD and not _is_on_input(use) for use in uses)
    keyboard = "" if has_keyboard else ", keyboard: none"
    return f", modules: {{{', '.join(f'{module}: {{}}' for module in modules)}}}{keyboard}"


def _is_on_input(use: Declared) -> bool:
    return use.word("ON") == "BINARY_INPUT"
