"""README.md on a fresh machine: its commands and files, in the order printed, in a clone where nothing else was done.

A pytest of another project comes first on the PATH, as on the machine of a developer.  Blocks that are
marked `elsewhere` are not run: the containers have a stage of their own.
"""

import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from addresses import exchanged
from clone import copy_clone
from doc_pages import ROOT, Block, blocks
from process_group import run_group

from fieldrig.testing import free_port, return_port

pytestmark = [pytest.mark.system, pytest.mark.timeout(1800)]

README = ROOT / "README.md"
PORTS = ("5020", "7447", "29536")
FIRST_SHELL = "make lab\n"
READY = "ready in"


class FreshMachine:
    """A clone as git makes one, and an environment of another project whose pytest comes first."""

    def __init__(self, folder: Path) -> None:
        self.clone = folder / "fieldrig"
        copy_clone(self.clone)
        other = folder / "other"
        subprocess.run([sys.executable, "-m", "venv", str(other)], check=True)
        subprocess.run([other / "bin/python", "-m", "pip", "install", "--quiet", "pytest"], check=True)
        self._ports = {port: str(free_port()) for port in PORTS}
        rig = self.clone / "configs/lab.yaml"
        rig.write_text(exchanged(rig.read_text(encoding="utf-8"), self._ports), encoding="utf-8")
        kept = {
            name: value for name, value in os.environ.items() if not name.startswith(("FIELDRIG", "PYTHON", "VIRTUAL"))
        }
        endpoint = f"tcp/127.0.0.1:{self._ports['7447']}"
        path = os.pathsep.join([str(other / "bin"), os.environ["PATH"]])
        self.environment = {**kept, "PATH": path, "FIELDRIG_CONTROL": endpoint}

    def run(self, script: str) -> None:
        """Run a script in the folder of the clone; every command in it must succeed."""
        command = ["bash", "-euxo", "pipefail", "-c", exchanged(script, self._ports)]
        done = run_group(command, self.clone, self.environment)
        assert done.returncode == 0, done.stdout

    @contextmanager
    def first_shell(self, command: str) -> Iterator[None]:
        """Run a command until its rig is ready, and stop it at the end as Ctrl-C does."""
        log = self.clone.with_name("first-shell.log")
        with log.open("wb") as output:
            shell = subprocess.Popen(
                ["bash", "-c", exchanged(command, self._ports)],
                cwd=self.clone,
                env=self.environment,
                stdout=output,
                stderr=subprocess.STDOUT,
                start_new_session=True,
            )
        try:
            while READY not in log.read_text():  # the limit of the test bounds it: pip may take long
                assert shell.poll() is None, log.read_text()
                time.sleep(0.1)
            yield
        finally:
            os.killpg(shell.pid, signal.SIGINT)
            shell.wait(60)

    def close(self) -> None:
        for port in self._ports.values():
            return_port(int(port))


@pytest.fixture
def machine() -> Iterator[FreshMachine]:
    with tempfile.TemporaryDirectory(prefix="new") as folder:  # short, as Unix sockets ask for
        machine = FreshMachine(Path(folder))
        yield machine
        machine.close()


def test_every_command_and_file_in_the_order_printed(machine: FreshMachine) -> None:
    [first, *others] = [block for block in blocks(README) if block.info[1:2] != ("elsewhere",)]
    assert commands(first) == FIRST_SHELL
    with machine.first_shell(FIRST_SHELL):
        machine.run("".join(as_script(block) for block in others))


def test_a_pytest_without_fieldrig_says_what_is_missing(machine: FreshMachine) -> None:
    [test] = [block for block in blocks(README) if block.info[1:2] == ("test",)]
    (machine.clone / test.info[2]).write_text(test.text, encoding="utf-8")
    command = ["pytest", test.info[2]]
    done = subprocess.run(
        command, cwd=machine.clone, env=machine.environment, capture_output=True, text=True, check=False
    )
    assert "Missing required plugins: fieldrig" in done.stdout + done.stderr
    assert "INTERNALERROR" not in done.stdout + done.stderr


def test_targets_of_make_exist() -> None:
    targets = set(re.findall(r"^([a-z-]+):", (ROOT / "Makefile").read_text(encoding="utf-8"), re.MULTILINE))
    assert set(re.findall(r"\bmake ([a-z-]+)", README.read_text(encoding="utf-8"))) <= targets


def as_script(block: Block) -> str:
    """Return the commands for the second shell that run a block, or save it as a file."""
    if block.info[1:2] == ("test",):
        return f"cat > {block.info[2]} << 'END'\n{block.text}END\n"
    return commands(block) if all(shutil.which(program) for program in block.info[2:]) else ""


def commands(block: Block) -> str:
    """Return the commands of a block; in a transcript those are behind a prompt."""
    if block.info[0] != "console":
        return block.text
    lines = [line.removeprefix("$ ") for line in block.text.splitlines() if line.startswith("$ ")]
    return "\n".join([*lines, ""])
