"""The public names of the packages: all there, known to mypy and editors, and free until they are used.

Whatever a user is shown (docs, examples, and what `fieldrig new` writes) imports nothing else.
"""

import ast
import re
import subprocess
import sys
from importlib import import_module
from pathlib import Path

import pytest
from doc_pages import PAGES, ROOT, place_of
from public_face import LAZY, PUBLIC, imported_names

from fieldrig_devices.begin.eds_rig import content_for

SHOWN = [*PAGES, *sorted((ROOT / "configs").rglob("*.py"))]
IMPORT = re.compile(r"\bfrom +(fieldrig[\w.]*) +import +((?:\w+(?: as \w+)?(?:, *)?)+)|\bimport +(fieldrig[\w.]*)")
DOTTED = re.compile(r"`(fieldrig(?:_bus|_devices)[\w.]+)\b")


@pytest.mark.parametrize("package", LAZY)
def test_public_names_of_a_package_are_those_that_mypy_and_editors_see(package: str) -> None:
    module = import_module(package)
    assert module.__file__ is not None
    tree = ast.parse(Path(module.__file__).read_text(encoding="utf-8"))
    [typed] = [node for node in tree.body if isinstance(node, ast.If)]
    seen = dict.fromkeys(imported_names(ast.Module(typed.body, [])))
    assert {name for _, name in seen} == set(module.__all__)
    for place, name in seen:
        assert getattr(module, name) is getattr(import_module(place), name), f"{package}.{name}"


@pytest.mark.parametrize("package", PUBLIC)
def test_public_names_exist_and_nothing_else_is_found(package: str) -> None:
    module = import_module(package)
    assert [name for name in module.__all__ if name not in dir(module)] == []
    assert [name for name in module.__all__ if getattr(module, name) is None] == []
    assert not hasattr(module, "no_such_name")


def test_submodules_are_found_beside_public_names() -> None:
    from fieldrig import S
    from fieldrig.config import kinds

    assert (S, kinds.__name__) == (1_000_000_000, "fieldrig.config.kinds")


@pytest.mark.long
def test_public_packages_import_nothing_until_a_name_is_used() -> None:
    code = f"import sys, {', '.join(LAZY)}; print(*sorted(name for name in sys.modules if name.startswith('fieldrig')))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    parents = {"fieldrig_bus", "fieldrig_bus.ring", "fieldrig_devices", "fieldrig.lazy"}
    assert set(done.stdout.split()) == {*LAZY, *parents}


def hidden_names(text: str) -> list[str]:
    """Return what a text in Python, in the shell or in English imports or names that is not public."""
    wrong = []
    for module, names, whole in IMPORT.findall(text):
        listed = import_module(module).__all__ if module in PUBLIC else []
        bare = [name.split(" as ")[0].strip() for name in names.split(",")]
        wrong += [f"{module}.{name}" for name in bare if name and name not in listed]
        wrong += [whole] if whole and whole not in PUBLIC else []
    for name in DOTTED.findall(text):
        module, _, last = name.rpartition(".")
        if name not in PUBLIC and not (module in PUBLIC and last in import_module(module).__all__):
            wrong.append(name)
    return wrong


@pytest.mark.parametrize("file", SHOWN, ids=place_of)
def test_what_users_read_imports_public_names_only(file: Path) -> None:
    assert hidden_names(file.read_text(encoding="utf-8")) == []


def test_a_fresh_project_imports_public_names_only() -> None:
    files = content_for(ROOT / "configs" / "eds" / "io32.eds")
    texts = [data.decode() for path, data in files.items() if path.suffix == ".py"]
    assert texts
    assert [hidden_names(text) for text in texts] == [[]] * len(texts)


@pytest.mark.parametrize(
    "text",
    [
        "from fieldrig.clock import S",
        "from fieldrig import Supervisor",
        "from fieldrig_bus.can import CanFrame, check",
        "    import fieldrig.virtual.rig",
        'python -c "from fieldrig_devices.arp.can.face import EDS as CARD; print(CARD)"',
        "give the link to `fieldrig_devices.sercos.master.SercosMaster`",
    ],
)
def test_a_private_name_is_found(text: str) -> None:
    assert len(hidden_names(text)) == 1
