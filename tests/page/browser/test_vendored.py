"""The files of others in the page are those of their packages, byte for byte; `lock.json` beside them names both."""

import base64
import hashlib
import json
import os
import shutil
import subprocess
import tarfile
from pathlib import Path
from typing import Any

import pytest

import fieldrig_page

VENDOR = Path(fieldrig_page.__file__).parent / "static" / "vendor"
LOCK: dict[str, Any] = json.loads((VENDOR / "lock.json").read_text())


def integrity(data: bytes) -> str:
    """Return the digest as npm and browsers write it."""
    return f"sha512-{base64.b64encode(hashlib.sha512(data).digest()).decode()}"


def test_the_files_are_those_of_the_lock_and_each_package_brings_its_licence() -> None:
    files = {name: file for package in LOCK.values() for name, file in package["files"].items()}
    assert {path.name for path in VENDOR.iterdir()} == {*files, "lock.json"}
    for name, file in files.items():
        assert integrity((VENDOR / name).read_bytes()) == file["sha512"], name
    for package, entry in LOCK.items():
        assert any(file["path"] == "LICENSE" for file in entry["files"].values()), package


@pytest.mark.real
@pytest.mark.parametrize("package", LOCK)
def test_the_files_are_those_of_the_registry(package: str, tmp_path: Path) -> None:
    npm = shutil.which("npm")
    if npm is None:
        pytest.skip("needs npm: apt-get install npm")
    command = [npm, "pack", "--json", "--fetch-retries=1", "--fetch-timeout=20000", package]
    packed = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=100, check=False)
    if packed.returncode != 0 and not os.environ.get("CI"):
        pytest.skip(f"the registry of npm does not answer: {packed.stderr[-200:]}")
    assert packed.returncode == 0, packed.stderr
    archive = tmp_path / json.loads(packed.stdout)[0]["filename"]
    assert integrity(archive.read_bytes()) == LOCK[package]["archive"]
    with tarfile.open(archive) as content:
        for name, file in LOCK[package]["files"].items():
            original = content.extractfile(f"package/{file['path']}")
            assert original is not None
            assert original.read() == (VENDOR / name).read_bytes(), name
