"""The extension as a package: the .vsix file, its manifest, and the folder of extensions."""

import io
import json
import re
import stat
import zipfile
from pathlib import Path
from typing import Any
from xml.etree import ElementTree as ET

import pytest
from typer.testing import CliRunner

from fieldrig_devices.editor.commands import app
from fieldrig_devices.editor.package import extension_files, manifest
from fieldrig_devices.editor.vsix import vsix
from fieldrig_devices.iec.dialect import DIALECTS

OPC = "{http://schemas.openxmlformats.org/package/2006/content-types}"
VSX = "{http://schemas.microsoft.com/developer/vsx-schema/2011}"


def editor(*arguments: object) -> Any:
    return CliRunner().invoke(app, [str(argument) for argument in arguments])


@pytest.fixture
def package(tmp_path: Path) -> zipfile.ZipFile:
    file = tmp_path / "made.vsix"
    assert editor("pack", "--out", file).stdout == f"written: {file}\n"
    return zipfile.ZipFile(io.BytesIO(file.read_bytes()))


def test_each_file_of_the_package_has_a_type(package: zipfile.ZipFile) -> None:
    types = ET.fromstring(package.read("[Content_Types].xml"))
    known = {entry.attrib["Extension"] for entry in types.iter(f"{OPC}Default")}
    names = [name for name in package.namelist() if name != "[Content_Types].xml"]
    assert {Path(name).suffix[1:] for name in names} == known


def test_the_manifest_names_files_that_are_there(package: zipfile.ZipFile) -> None:
    described = ET.fromstring(package.read("extension.vsixmanifest"))
    identity = next(described.iter(f"{VSX}Identity")).attrib
    inside = json.loads(package.read("extension/package.json"))
    assert (identity["Id"], identity["Publisher"]) == (inside["name"], inside["publisher"])
    assert identity["Version"] == inside["version"] != "0.0.0"
    named = [asset.attrib["Path"] for asset in described.iter(f"{VSX}Asset")]
    contributed = inside["contributes"]
    named += [f"extension/{inside['main']}"]
    named += [f"extension/{grammar['path']}" for grammar in contributed["grammars"]]
    named += [f"extension/{language['configuration']}" for language in contributed["languages"]]
    assert {name.replace("/./", "/") for name in named} <= set(package.namelist())


def test_all_files_that_the_code_requires_are_packed(package: zipfile.ZipFile) -> None:
    for name in package.namelist():
        if name.endswith(".js"):
            text = package.read(name).decode()
            for required in re.findall(r'"\./(\w+)"', text):
                assert f"extension/{required}.js" in package.namelist()


def test_the_same_files_are_the_same_package() -> None:
    assert vsix(manifest(), extension_files()) == vsix(manifest(), extension_files())


def test_the_settings_know_the_dialects_and_languages_of_fieldrig() -> None:
    contributed = manifest()["contributes"]
    assert contributed["configuration"]["properties"]["fieldrig.dialect"]["enum"] == list(DIALECTS)
    languages = [language["id"] for language in contributed["languages"]]
    assert languages == contributed["debuggers"][0]["languages"]
    assert languages == [grammar["language"] for grammar in contributed["grammars"]]
    assert languages == [breakpoints["language"] for breakpoints in contributed["breakpoints"]]


# ---- installing


@pytest.fixture
def home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A home folder, and a path without any editor."""
    home = tmp_path / "home"
    home.mkdir()
    monkeypatch.setattr(Path, "home", lambda: home)
    monkeypatch.setenv("PATH", str(tmp_path / "bin"))
    return home


def test_without_an_editor_it_says_what_to_do(home: Path) -> None:
    done = editor("install")
    assert "there is no editor" in str(done.exception)
    assert "fieldrig editor pack" in str(done.exception)


def test_it_is_unpacked_into_the_folders_that_are_there(home: Path) -> None:
    (home / ".vscode-oss").mkdir()
    done = editor("install")
    folder = home / ".vscode-oss/extensions"
    own = folder / f"fieldrig.fieldrig-{manifest()['version']}"
    assert done.stdout == f"The extension is unpacked into {own} for VSCodium; start the editor again.\n"
    assert (own / "grammars/st.tmLanguage.json").is_file()
    command = json.loads((own / "installed.json").read_text())["command"]
    assert command[1:] == ["-m", "fieldrig"]
    (entry,) = json.loads((folder / "extensions.json").read_text())
    assert (entry["identifier"], entry["relativeLocation"]) == ({"id": "fieldrig.fieldrig"}, own.name)


def test_an_older_version_goes_and_other_extensions_stay(tmp_path: Path) -> None:
    folder = tmp_path / "extensions"
    old, other = folder / "fieldrig.fieldrig-0.0.9", folder / "a.b-1.0.0"
    old.mkdir(parents=True)
    other.mkdir()
    others = {"identifier": {"id": "a.b"}, "version": "1.0.0", "relativeLocation": other.name}
    own = {"identifier": {"id": "Fieldrig.fieldrig"}, "version": "0.0.9", "relativeLocation": old.name}
    (folder / "extensions.json").write_text(json.dumps([own, others]))
    assert editor("install", "--into", folder).exit_code == 0
    assert (old.exists(), other.exists()) == (False, True)
    listed = json.loads((folder / "extensions.json").read_text())
    assert listed[0] == others
    assert [entry["version"] for entry in listed] == ["1.0.0", manifest()["version"]]


def test_an_extension_that_was_uninstalled_before_is_not_removed_at_the_next_start(tmp_path: Path) -> None:
    own = f"fieldrig.fieldrig-{manifest()['version']}"
    file = tmp_path / ".obsolete"
    file.write_text(json.dumps({own: True, "a.b-1.0.0": True}))
    assert editor("install", "--into", tmp_path).exit_code == 0
    assert json.loads(file.read_text()) == {"a.b-1.0.0": True}


@pytest.mark.parametrize("text", ["{", "{}", "[1]", "\x00"])
def test_a_list_that_cannot_be_read_is_left_alone(tmp_path: Path, text: str) -> None:
    file = tmp_path / "extensions.json"
    file.write_text(text)
    done = editor("install", "--into", tmp_path)
    assert "extensions.json" in str(done.exception)
    assert "the editor writes it again" in str(done.exception)
    assert (file.read_text(), sorted(tmp_path.iterdir())) == (text, [file])


@pytest.mark.system
@pytest.mark.parametrize("code", [0, 3])
def test_an_editor_on_the_path_installs_it_itself(home: Path, code: int) -> None:
    command = home.parent / "bin/codium"
    command.parent.mkdir()
    command.write_text(f'#!/bin/sh\necho "$@" > "{home}/asked"\necho no room >&2\nexit {code}\n')
    command.chmod(command.stat().st_mode | stat.S_IXUSR)
    done = editor("install")
    words = (home / "asked").read_text().split()
    assert (words[0], Path(words[1]).suffix, words[2]) == ("--install-extension", ".vsix", "--force")
    if code:
        assert "has not installed the extension: no room" in str(done.exception)
    else:
        assert done.stdout == "VSCodium has installed the extension, by `codium --install-extension`.\n"
