"""The commands of release.md, in the order printed, in a clone; what `make` runs has tests of its own."""

import os
import sys
import tomllib
from pathlib import Path
from zipfile import ZipFile

import pytest
from clone import copy_clone
from doc_pages import ROOT, blocks, page_named
from process_group import run_group
from tests.driver.release import CHANGELOG, PROJECT, sections

pytestmark = pytest.mark.system

WHERE = "import fieldrig.clock; print(fieldrig.clock.__file__)"
GIT = {"GIT_AUTHOR_NAME": "a", "GIT_AUTHOR_EMAIL": "a@b", "GIT_COMMITTER_NAME": "a", "GIT_COMMITTER_EMAIL": "a@b"}


@pytest.fixture
def clone(tmp_path: Path) -> Path:
    """A clone that has unreleased changes."""
    copy_clone(tmp_path)
    (tmp_path / ".venv").symlink_to(sys.prefix)
    changelog = tmp_path / CHANGELOG
    text = changelog.read_text(encoding="utf-8")
    changelog.write_text(text.replace("## [Unreleased]\n", "## [Unreleased]\n\n### Security\n\n- News.\n"), "utf-8")
    return tmp_path


def test_the_commands_of_the_page_make_a_release(clone: Path) -> None:
    lines = [line for block in blocks(page_named("release.md")) for line in block.text.splitlines()]
    script = "\n".join(("git init --quiet", "git add .", *(line for line in lines if " make " not in f" {line}")))
    done = run_group(["bash", "-euxo", "pipefail", "-c", script], clone, {**os.environ, **GIT})
    assert done.returncode == 0, done.stdout
    assert tomllib.loads((clone / PROJECT).read_text(encoding="utf-8"))["project"]["version"] == "0.2.0"
    assert next(sections((clone / CHANGELOG).read_text(encoding="utf-8"))).version == "0.2.0"
    assert "fieldrig/__init__.py" in done.stdout
    assert "fieldrig_devices/examples/lab.yaml" in done.stdout
    with ZipFile(clone / "dist" / "fieldrig-0.2.0.vsix") as extension:
        assert b'Version="0.2.0"' in extension.read("extension.vsixmanifest")
    # The environment is that of the tests, and still has the code that they judge.
    assert str(ROOT / "emulator") in run_group([sys.executable, "-c", WHERE], ROOT, {**os.environ}).stdout


def test_what_the_page_makes_exists() -> None:
    targets = (ROOT / "Makefile").read_text(encoding="utf-8")
    lines = [line for block in blocks(page_named("release.md")) for line in block.text.splitlines()]
    made = [line.rpartition("make ")[2] for line in lines if "make " in line]
    assert made
    assert all(f"\n{target}:" in targets for target in made)
