"""The public names of the packages: all there, known to mypy and editors, and free until they are used."""

import ast
import subprocess
import sys
from importlib import import_module
from pathlib import Path

import pytest
from public_face import LAZY, PUBLIC, imported_names


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
    from fieldrig import S, kinds

    assert (S, kinds.__name__) == (1_000_000_000, "fieldrig.kinds")


@pytest.mark.long
def test_public_packages_import_nothing_until_a_name_is_used() -> None:
    code = f"import sys, {', '.join(LAZY)}; print(*sorted(name for name in sys.modules if name.startswith('fieldrig')))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    parents = {"fieldrig_bus", "fieldrig_bus.ring", "fieldrig_devices", "fieldrig.lazy"}
    assert set(done.stdout.split()) == {*LAZY, *parents}
