"""The editors on this machine, and how the extension gets into one of them.

An editor that has a command installs the .vsix file itself.  For one without, as on a server to which an editor
connects, the files are unpacked into its folder of extensions, and written into the list that the folder has of them
(`extensions.json`), without which Visual Studio Code from 1.75 on does not load a folder that is new.
"""

import json
import shutil
import subprocess
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from typing import Any, Final

from fieldrig.errors import UsageError
from fieldrig.system.whole_file import replace_file

_LIST: Final = "extensions.json"
_OBSOLETE: Final = ".obsolete"
"""The file with the folders of extensions that the editor removes when it starts, after they were uninstalled."""
_PATIENCE_S: Final = 120.0
"""The longest time that an editor's command may take."""


@dataclass(frozen=True, slots=True)
class Editor:
    name: str
    command: str
    folder: str
    """Its folder of extensions, below the home folder."""


EDITORS: Final = (
    Editor("Visual Studio Code", "code", ".vscode/extensions"),
    Editor("Visual Studio Code Insiders", "code-insiders", ".vscode-insiders/extensions"),
    Editor("VSCodium", "codium", ".vscode-oss/extensions"),
    Editor("code-server", "code-server", ".local/share/code-server/extensions"),
    Editor("Visual Studio Code Server", "", ".vscode-server/extensions"),
)


def with_command() -> list[tuple[Editor, str]]:
    """Return the editors whose command is on the path, with the path of the command."""
    found = ((editor, shutil.which(editor.command)) for editor in EDITORS if editor.command)
    return [(editor, path) for editor, path in found if path is not None]


def with_folder(home: Path) -> list[tuple[Editor, Path]]:
    """Return the editors whose folder of extensions is there, or the folder above it."""
    folders = ((editor, home / editor.folder) for editor in EDITORS)
    return [(editor, folder) for editor, folder in folders if folder.parent.is_dir()]


def install_by_command(command: str, package: Path) -> None:
    """Let an editor install a .vsix file.  UsageError, with its words, if it does not."""
    call = [command, "--install-extension", str(package), "--force"]
    try:
        done = subprocess.run(
            call, capture_output=True, encoding="utf-8", errors="replace", timeout=_PATIENCE_S, check=False
        )
    except (OSError, subprocess.TimeoutExpired) as cause:
        raise UsageError(f"{command} cannot install the extension: {cause}", _BY_HAND) from cause
    if done.returncode != 0:
        words = " ".join((done.stderr or done.stdout).split())[:500]
        raise UsageError(f"{command} has not installed the extension: {words}", _BY_HAND)


_BY_HAND: Final = "`fieldrig editor install --into FOLDER` unpacks it into a folder of extensions"


def unpack(folder: Path, manifest: Mapping[str, Any], files: Mapping[str, bytes]) -> Path:
    """Write the files into a folder of extensions, in the place of other versions.  Return the extension's folder.

    OSError if they cannot be written, UsageError if the folder's list of extensions cannot be read.
    """
    identity = f"{manifest['publisher']}.{manifest['name']}"
    listed = _listed(folder / _LIST)
    own = folder / f"{identity}-{manifest['version']}"
    for old in folder.glob(f"{identity}-*"):
        shutil.rmtree(old)
    for name, data in files.items():
        file = own.joinpath(*PurePosixPath(name).parts)
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_bytes(data)
    others = [entry for entry in listed if entry.get("identifier", {}).get("id", "").lower() != identity]
    entry = {
        "identifier": {"id": identity},
        "version": manifest["version"],
        "location": {"$mid": 1, "path": own.absolute().as_posix(), "scheme": "file"},
        "relativeLocation": own.name,
        "metadata": {"isApplicationScoped": False, "isMachineScoped": False, "isBuiltin": False, "source": "vsix"},
    }
    replace_file(folder / _LIST, json.dumps([*others, entry]).encode())
    _keep(folder / _OBSOLETE, own.name)
    return own


def _keep(file: Path, name: str) -> None:
    """Take a folder out of those that are removed; what cannot be read is left to the editor."""
    try:
        names = json.loads(file.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return
    if isinstance(names, dict) and names.pop(name, None) is not None:
        replace_file(file, json.dumps(names).encode())


def _listed(file: Path) -> Sequence[dict[str, Any]]:
    """Return the entries of a list of extensions; none if there is no list."""
    try:
        entries = json.loads(file.read_text(encoding="utf-8"))
    except FileNotFoundError:
        return []
    except ValueError as cause:
        raise UsageError(f"{file} cannot be read: {cause}", "the editor writes it again if it is removed") from cause
    if not isinstance(entries, list) or not all(isinstance(entry, dict) for entry in entries):
        raise UsageError(f"{file} is no list of extensions", "the editor writes it again if it is removed")
    return entries
