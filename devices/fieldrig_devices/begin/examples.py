"""The examples that `fieldrig new` copies: the rig files of `configs`, which the wheel contains in this package.

An example is a rig file, and the first sentence of its opening comment describes it.  Its variants (`lab-vcan.yaml`
extends `lab.yaml`), its test (`test_lab.py`), and every file that one of them names belong to it.  A rig file that is
added to the folder therefore appears in the menu by itself.
"""

from collections.abc import Mapping
from importlib.resources import files
from itertools import takewhile
from pathlib import Path, PurePosixPath
from typing import Any

from fieldrig.config.yaml_source import read
from fieldrig_devices.begin.named_files import SUFFIX, named_files


def folder() -> Path:
    """Return the folder of the examples: in the installed package, or in the clone of an editable installation."""
    package = Path(str(files("fieldrig_devices")))
    packed = package / "examples"
    return packed if packed.is_dir() else package.parents[1] / "configs"


def menu() -> dict[str, str]:
    """Return the description of each example by name."""
    rigs = sorted(folder().glob(f"*{SUFFIX}"))
    return {rig.stem: _sentence(rig) for rig in rigs if not _is_variant(rig)}


def content_of(example: str) -> Mapping[PurePosixPath, bytes]:
    """Return the files of an example by path, the rig file first."""
    root = folder()
    rigs = [root / f"{example}{SUFFIX}", *sorted(root.glob(f"{example}-*{SUFFIX}"))]
    found: dict[Path, None] = {}
    for rig in (rig for rig in rigs if rig.stem == example or _is_variant(rig)):
        found |= dict.fromkeys(file for file in named_files(rig) if file.resolve().is_relative_to(root.resolve()))
    test = root / f"test_{example.replace('-', '_')}.py"
    return {PurePosixPath(file.relative_to(root).as_posix()): file.read_bytes() for file in (*found, test)}


def _sentence(rig: Path) -> str:
    with rig.open(encoding="utf-8") as lines:
        comment = takewhile(lambda line: line.startswith("#"), lines)
        text = " ".join(line.removeprefix("#").strip() for line in comment)
    sentence, dot, _ = text.partition(". ")
    return sentence + dot.strip()


def _data(rig: Path) -> Any:
    return read(rig.read_text(encoding="utf-8"), rig.name).data


def _is_variant(rig: Path) -> bool:
    bases = _data(rig).get("extends", [])
    names = [bases] if isinstance(bases, str) else bases
    return any(rig.stem.startswith(f"{name.removesuffix(SUFFIX)}-") for name in names)
