"""The tables of reference.md: `python tests/support/reference_page.py` writes them again from the code."""

import ast
import inspect
import os
import re
from collections.abc import Iterator
from functools import cache
from importlib import import_module
from itertools import pairwise
from pathlib import Path
from types import ModuleType
from typing import Any

from doc_pages import ROOT, page_named
from public_face import PUBLIC

PAGE = page_named("reference.md")
BEGIN, END = "<!-- names -->\n", "<!-- end of names -->\n"
CONTRIBUTING = "CONTRIBUTING.md"
DEVICE, BUS, TESTS = f"{CONTRIBUTING}#adding-a-device", f"{CONTRIBUTING}#adding-a-bus", "testing-with-fieldrig.md"
PAGES = {
    "fieldrig.loop.background": DEVICE,
    "fieldrig.bus": BUS,
    "fieldrig.clock": "architecture.md",
    "fieldrig.config.rig_file": "rig-file.md",
    "fieldrig.coverage.covered": "coverage.md",
    "fieldrig.device": DEVICE,
    "fieldrig.front": "fronts.md",
    "fieldrig.link": "architecture.md#interest",
    "fieldrig.programs": "python-tests.md",
    "fieldrig.settings": DEVICE,
    "fieldrig.storage.store": DEVICE,
    "fieldrig": TESTS,
    "fieldrig.virtual.branch": "branches.md",
    "fieldrig_bus.can": "buses.md",
    "fieldrig_bus.modbus": "buses.md",
    "fieldrig_bus.opcua": "opcua.md",
    "fieldrig_bus.ring.pam": "pam-ring.md",
    "fieldrig_bus.ring.sercos": "ring.md",
    "fieldrig_bus.serial": "buses.md",
    "fieldrig_bus.wires": "buses.md",
    "fieldrig_bus.signals": "pulses.md",
    "fieldrig_devices.arp.can": "arp-can.md",
    "fieldrig_devices.arp.user_port": "arp-user-port.md",
    "fieldrig_devices.conformance": "conformance.md",
    "fieldrig_devices.dial": "dial.md",
    "fieldrig_devices.cia402": "cia402-drive.md",
    "fieldrig_devices.max4": "cia402.md",
    "fieldrig_devices.opcua": "opcua.md",
    "fieldrig_devices.pam": "pam-ports.md",
    "fieldrig_devices.pam.ports.masters.rs422": "pam-rs422.md",
    "fieldrig_devices.pamring": "st1.md",
    "fieldrig_devices.ppp": "dial.md",
    "fieldrig_devices.replay": "replay.md",
    "fieldrig_devices.scenarios": "scenarios.md",
    "fieldrig_devices.sercos": "ring.md",
}
"""The page that explains the names of a module and of those below it; the longest name of a module counts."""


def text() -> str:
    """Return everything between the marks: a table for each public module."""
    return "\n".join(_section(name, import_module(name)) for name in PUBLIC)


def written() -> str:
    """Return what is between the marks of the page."""
    return PAGE.read_text(encoding="utf-8").partition(BEGIN)[2].partition(END)[0]


def _section(name: str, module: ModuleType) -> str:
    rows = [row for public in module.__all__ for row in _rows(public, module)]
    return "\n".join([f"## `{name}`\n", "| name | meaning |", "|---|---|", *rows]) + "\n"


def _rows(name: str, module: ModuleType) -> Iterator[str]:
    value, home = getattr(module, name), home_of(name, module)
    yield f"| [`{_cell(name + signature(value))}`]({_page(home)}) | {_cell(about(name, module))} |"
    if inspect.isclass(value) and not issubclass(value, BaseException | tuple):
        for method, call in vars(value).items():
            if inspect.isfunction(call) and not method.startswith("_") and call.__doc__:
                yield f"| `{_cell(f'{name}.{method}{signature(call)}')}` | {_cell(_first_sentence(call.__doc__))} |"


def about(name: str, module: ModuleType) -> str:
    """Return the first sentence of the docstring of a name; empty if it has none."""
    value = getattr(module, name)
    if inspect.isclass(value) or inspect.isfunction(value):
        own = vars(value).get("__doc__") if inspect.isclass(value) else value.__doc__
        return "" if own is None or own.startswith(f"{name}(") else _first_sentence(own)
    return _first_sentence(_texts_of(home_of(name, module)).get(name, ""))


def home_of(name: str, module: ModuleType) -> str:
    """Return the module that defines a public name."""
    assert module.__file__ is not None
    for node in ast.walk(ast.parse(Path(module.__file__).read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom) and name in (alias.name for alias in node.names):
            assert node.module is not None
            return node.module
    return module.__name__


@cache
def _texts_of(module: str) -> dict[str, str]:
    """Return the texts below the assignments of a module, by name."""
    file = import_module(module).__file__
    assert file is not None
    body = ast.parse(Path(file).read_text(encoding="utf-8")).body
    found: dict[str, str] = {}
    for node, after in pairwise(body):
        targets = (
            node.targets if isinstance(node, ast.Assign) else [node.target] if isinstance(node, ast.AnnAssign) else []
        )
        if isinstance(after, ast.Expr) and isinstance(after.value, ast.Constant) and isinstance(after.value.value, str):
            found |= {target.id: after.value.value for target in targets if isinstance(target, ast.Name)}
    return found


def signature(value: Any) -> str:
    """Return the arguments of a call as they are written; empty for what is not called."""
    if not (inspect.isclass(value) or inspect.isfunction(value)) or _is_not_called(value):
        return ""
    said = inspect.signature(value)
    parameters = [part for name, part in said.parameters.items() if name != "self"]
    line = str(said.replace(parameters=parameters)).removesuffix(" -> None")
    line = re.sub(r"~|\b(?:[a-z_]\w*\.)+(?=\w)", "", line)
    line = re.sub(r"(?<=: )'([^']+)'", r"\1", line)  # an annotation that is written as a text
    return re.sub(r"<function [^>]*>+(?: at \w+>)?", "...", re.sub(r"<(\w+\.\w+): [^>]*>", r"\1", line))


def _is_not_called(value: Any) -> bool:
    if inspect.isclass(value) and issubclass(value, BaseException):
        return True
    is_abstract = getattr(value, "_is_protocol", False) or inspect.isabstract(value)
    return inspect.isclass(value) and (is_abstract or "__members__" in dir(value) or hasattr(value, "model_fields"))


def _page(home: str) -> str:
    while home not in PAGES:
        home = home.rpartition(".")[0]
    name, mark, part = PAGES[home].partition("#")
    target = ROOT / name if name == CONTRIBUTING else page_named(name)
    return os.path.relpath(target, PAGE.parent) + mark + part


def _first_sentence(doc: str) -> str:
    paragraph = " ".join(inspect.cleandoc(doc).partition("\n\n")[0].split())
    return re.split(r"(?<=\.) (?=[A-Z`])", paragraph)[0]


def _cell(said: str) -> str:
    return said.replace("|", "\\|")


def main() -> None:
    page = PAGE.read_text(encoding="utf-8")
    before, rest = page.split(BEGIN)
    PAGE.write_text(before + BEGIN + text() + END + rest.partition(END)[2], encoding="utf-8")


if __name__ == "__main__":
    main()
