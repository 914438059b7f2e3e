"""The three paths of begin.md for a newcomer without a clone, as scripts that run with nothing but the wheel.

The wheel is built from this clone and installed with its dependencies into an empty virtual environment, as the first
script does it; so pip needs a package index, and keeps in its cache what it downloads.
"""

import hashlib
import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path, PurePath

import pytest
from addresses import exchanged
from doc_pages import ROOT, Block, blocks, page_named
from process_group import run_group

from fieldrig.testing import free_port
from fieldrig_devices.begin.examples import content_of, menu

pytestmark = [pytest.mark.system, pytest.mark.timeout(1800)]

SCRIPTS = Path(__file__).parent
FIRST, *OTHERS = "wheel_to_first_test.sh", "rig_file_to_first_reading.sh", "own_device_to_first_frame.sh"
PAGE = page_named("begin.md")
PORTS = ("7449", "5021", "29538")
PIP = [sys.executable, "-m", "pip", "--disable-pip-version-check"]
IN_THE_WHEEL = """
import hashlib, json, sys
from fieldrig_devices.begin.examples import content_of, menu
print(json.dumps({one: {str(p): hashlib.sha256(d).hexdigest() for p, d in content_of(one).items()} for one in menu()}))
"""


FILES_OF_THE_PAGE = """
import hashlib, json, fieldrig_page
from pathlib import Path, PurePath
top = Path(fieldrig_page.__file__).parent
files = [path for path in (top / "static").rglob("*") if path.is_file()]
print(json.dumps({str(path.relative_to(top)): hashlib.sha256(path.read_bytes()).hexdigest() for path in files}))
"""


COMMANDS = """
import sys
from fieldrig.cli import main

def run(words):
    sys.argv = ["fieldrig", *words]
    try:
        main()
    except SystemExit as end:
        assert not end.code, (words, end.code)

"""
"""A function that runs a command, and fails if the command does."""

ENDING = "trap 'jobs -p | xargs -r kill' EXIT\n"
"""Whatever a script has started ends with it."""


class Newcomer:
    """An empty folder of a machine that has Python and the wheel, and no clone."""

    def __init__(self, folder: Path, wheel: Path) -> None:
        self.folder = folder
        self._ports = {port: str(free_port()) for port in PORTS}
        kept = {name: value for name, value in os.environ.items() if not name.startswith(("FIELDRIG", "PYTHON"))}
        programs = (folder / ".venv/bin", Path(sys.base_prefix) / "bin", os.environ["PATH"])
        self._environment = {**kept, "PATH": os.pathsep.join(map(str, programs)), "WHEEL": str(wheel)}
        self._environment["PIP_COMPILE"] = "0"  # a newcomer imports little of what all packages have
        self._environment.pop("VIRTUAL_ENV", None)

    def save(self, block: Block) -> None:
        (self.folder / name_of(block)).write_text(exchanged(block.text, self._ports), encoding="utf-8")

    def run(self, script: str) -> None:
        """Every command must succeed; at a failure its output says how far it came."""
        script = ENDING + exchanged(script, self._ports)
        done = run_group(["bash", "-euxo", "pipefail", "-c", script], self.folder, self._environment)
        assert done.returncode == 0, done.stdout

    def python(self, code: str) -> str:
        command = [str(self.folder / ".venv/bin/python"), "-c", code]
        return subprocess.run(
            command, cwd=self.folder, env=self._environment, capture_output=True, text=True, check=True
        ).stdout


def name_of(block: Block) -> str:
    return block.info[2]


def is_saved(block: Block) -> bool:
    return len(block.info) == 3 and block.info[1] in ("file", "rig")


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("wheel")
    looked = subprocess.run([*PIP, "download", "-q", "--no-deps", "-d", folder / "look", "hatchling"], check=False)
    if looked.returncode != 0 and not os.environ.get("CI"):
        pytest.skip("pip reaches no package index")
    subprocess.run([*PIP, "wheel", "-q", "--no-deps", "--wheel-dir", folder, ROOT], check=True)
    return next(folder.glob("fieldrig-*.whl"))


@pytest.fixture(scope="module")
def newcomer(wheel: Path) -> Iterator[Newcomer]:
    """After the first path: its environment is the one that the others begin with."""
    with tempfile.TemporaryDirectory(prefix="new") as folder:  # short, as Unix sockets ask for
        newcomer = Newcomer(Path(folder), wheel)
        newcomer.run((SCRIPTS / FIRST).read_text(encoding="utf-8"))
        yield newcomer


def test_from_the_wheel_to_the_first_test(newcomer: Newcomer) -> None:
    assert (newcomer.folder / "bench/lab.yaml").is_file()


@pytest.mark.parametrize("script", OTHERS)
def test_a_path_of_the_page(newcomer: Newcomer, script: str) -> None:
    for block in filter(is_saved, blocks(PAGE)):
        newcomer.save(block)
    newcomer.run((SCRIPTS / script).read_text(encoding="utf-8"))


def test_the_wheel_has_the_examples_of_the_clone(newcomer: Newcomer) -> None:
    ours = {
        name: {str(path): hashlib.sha256(data).hexdigest() for path, data in content_of(name).items()}
        for name in menu()
    }
    assert json.loads(newcomer.python(IN_THE_WHEEL)) == ours


def test_the_wheel_has_the_files_of_the_page_with_their_licences(newcomer: Newcomer) -> None:
    top = ROOT / "page" / "fieldrig_page"
    files = [path for path in (top / "static").rglob("*") if path.is_file()]
    ours = {str(path.relative_to(top)): hashlib.sha256(path.read_bytes()).hexdigest() for path in files}
    assert json.loads(newcomer.python(FILES_OF_THE_PAGE)) == ours
    assert {"static/vendor/preact.mjs", "static/vendor/LICENSE.preact", "static/vendor/LICENSE.htm"} <= ours.keys()


def test_the_files_of_every_example_of_the_wheel_are_right(newcomer: Newcomer) -> None:
    """In one process, as each of these commands would import the same modules; the scripts start such commands."""
    commands = [
        words
        for example in menu()
        for words in (
            ["new", example, f"all/{example}"],
            *(["check", f"all/{example}/{path}"] for path in content_of(example) if is_rig(path)),
        )
    ]
    assert len(commands) > 2 * len(menu())
    done = newcomer.python(f"{COMMANDS}for words in {commands!r}:\n    run(words)\n")
    assert done.count(" has no mistakes") == len(commands) - len(menu())


def is_rig(path: PurePath) -> bool:
    return path.suffix == ".yaml" and len(path.parts) == 1


def test_the_scripts_take_the_way_of_the_page() -> None:
    """Every command of the page is one of a script, apart from what looks at its output there."""
    lines = [
        line for script in (FIRST, *OTHERS) for line in (SCRIPTS / script).read_text(encoding="utf-8").splitlines()
    ]
    commands = [
        line.partition("  #")[0] for block in blocks(PAGE) if block.info == ("sh",) for line in block.text.splitlines()
    ]
    said = [line.replace(" -q ", " ") for line in lines]
    assert [command for command in commands if not any(line.startswith(command) for line in said)] == []
