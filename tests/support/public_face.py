"""The modules that a user may import, and what a text in Python imports from fieldrig."""

import ast
from collections.abc import Iterator

LAZY = (
    "fieldrig",
    "fieldrig_bus.can",
    "fieldrig_bus.modbus",
    "fieldrig_bus.opcua",
    "fieldrig_bus.ring.pam",
    "fieldrig_bus.ring.sercos",
    "fieldrig_bus.serial",
    "fieldrig_devices.arp",
    "fieldrig_devices.cia402",
    "fieldrig_devices.conformance",
    "fieldrig_devices.dial",
    "fieldrig_devices.max4",
    "fieldrig_devices.opcua",
    "fieldrig_devices.pam",
    "fieldrig_devices.pamring",
    "fieldrig_devices.replay",
    "fieldrig_devices.scenarios",
    "fieldrig_devices.sercos",
)
"""Packages whose public names are imported when they are used."""
PUBLIC = (*LAZY, "fieldrig.front", "fieldrig.testing", "fieldrig_bus.wires")


def imported_names(tree: ast.AST) -> Iterator[tuple[str, str]]:
    """Yield each module of fieldrig's packages that is imported, with a name imported from it, or an empty text."""
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and node.module is not None and _is_ours(node.module):
            yield from ((node.module, alias.name) for alias in node.names)
        elif isinstance(node, ast.Import):
            yield from ((alias.name, "") for alias in node.names if _is_ours(alias.name))


def _is_ours(module: str) -> bool:
    return module.partition(".")[0] in ("fieldrig", "fieldrig_bus", "fieldrig_devices")
