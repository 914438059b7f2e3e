"""The documentation does what it says: every block of every page is run, as `doc_pages` tells.

Each page is tried in a folder of its own that looks like a clone with an activated .venv.  Ports are exchanged for
free ones in what is run, and back in what is printed.  `fieldrig` and `python -m pytest` are forks of one process, as
`forked_cli` says; a block that activates the .venv itself, as in README.md and begin.md, has the commands of a user.
"""

import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from types import TracebackType
from typing import Final, Self

import forked_cli
import pytest
from addresses import exchanged, ports_in
from doc_pages import PAGES, ROOT, Block, blocks, place_of
from process_group import run_group

from fieldrig.outside.page_seat import NO_PAGE_VARIABLE
from fieldrig.testing import free_port, return_port

pytestmark = [pytest.mark.system, pytest.mark.timeout(1800)]

LAB_PORTS: Final = {"5020", "7447", "29536"}
"""The ports of the lab.  7447 is the default of `control`, and so in no rig file."""
BESIDE = {"eds": "configs/eds", "registers": "configs/registers", ".venv": sys.prefix}
"""The files that the rig files of a page find beside them."""
PATIENCE_S = 600.0
"""Bounds a block that hangs; the tour of the ring takes 20 s of two free processors, and minutes of a busy host."""
PROMPT = "$ "
MAKE_LAB = "make lab"
"""The command whose output is that of the lab that runs for the page."""


class Desk:
    """The folder and rigs in which one page is tried."""

    def __init__(self, page: Sequence[Block]) -> None:
        self._temporary = tempfile.TemporaryDirectory(prefix="doc")  # short, as Unix sockets ask for
        self.folder = Path(self._temporary.name)
        for name in ("configs", "docker"):
            shutil.copytree(ROOT / name, self.folder / name)
        for name, target in BESIDE.items():
            (self.folder / name).symlink_to(target)
        rigs = {file: file.read_text(encoding="utf-8") for file in (self.folder / "configs").glob("*.yaml")}
        known = LAB_PORTS.union(*(ports_in(text) for text in (*rigs.values(), *(block.text for block in page))))
        self._ports = {port: str(free_port()) for port in sorted(known)}
        for file, text in rigs.items():
            file.write_text(self._with_free_ports(text), encoding="utf-8")
        self._originals = {free: port for port, free in self._ports.items()}
        forked_cli.save_commands(self.folder / "forked")
        programs = (str(self.folder / "forked"), str(self.folder / ".venv/bin"), os.environ["PATH"])
        self._environment = {**os.environ, "PATH": os.pathsep.join(programs)}
        self._environment.pop("FIELDRIG_CONTROL", None)
        if any("page to operate" in block.text for block in page):
            self._environment.pop(NO_PAGE_VARIABLE, None)
        self._lab: subprocess.Popen[bytes] | None = None
        self.missing: list[str] = []

    def try_block(self, block: Block) -> None:
        match block.info:
            case (_, "elsewhere") | ("text",):
                return
            case ("iecst", "becomes") | ("text", "messages"):
                return  # tests/devices/iec/imports/test_page.py compares them
            case (_, "file", name):
                self._save(name, block)
            case ("python", "test", *names):
                file = self._save(names[0] if names else f"test_line_{block.line}.py", block)
                self._run(block, f"python -m pytest -q -W error -p no:cacheprovider {file.name}")
            case ("yaml", "rig", *names):
                file = self._save(names[0] if names else "rig.yaml", block)
                self._run(block, f"fieldrig check {file.name}")
            case ("sh",):
                self._run(block, block.text)
            case ("sh", "lab" | "with" as word, *programs):
                if self._has(programs):
                    self._run(block, block.text, with_lab=word == "lab")
            case ("console", *words):
                if self._has(set(words) - {"lab", "fails"}):
                    self._follow(block, with_lab="lab" in words, fails="fails" in words)
            case _:
                pytest.fail(f"{block.place}: there is no test for a block of {' '.join(block.info)!r}")

    def close(self) -> None:
        if self._lab is not None:
            self._lab.send_signal(signal.SIGTERM)
            self._lab.wait(PATIENCE_S)
        for port in self._ports.values():
            return_port(int(port))
        self._temporary.cleanup()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, fault: BaseException | None, tb: TracebackType | None) -> None:
        self.close()

    def _has(self, programs: Iterable[str]) -> bool:
        missing = [program for program in programs if shutil.which(program) is None]
        self.missing += missing
        return not missing

    def _save(self, name: str, block: Block) -> Path:
        file = self.folder / name
        file.write_text(self._with_free_ports(block.text), encoding="utf-8")
        return file

    def _follow(self, block: Block, *, with_lab: bool, fails: bool) -> None:
        for command, expected in _transcript(block):
            if command == MAKE_LAB:
                self._lab_endpoint()
                output = self._with_known_ports((self.folder / "lab.out").read_text(encoding="utf-8"))
            else:
                output = self._run(block, command, with_lab=with_lab, fails=fails)
            heard = _plain(output)
            for line in expected:
                pattern = r".*".join(re.escape(part.strip()) for part in _plain(line).split("..."))
                assert re.search(pattern, heard), f"{block.place}: {command}\ndoes not say: {line}\nbut:\n{output}"

    def _run(self, block: Block, command: str, *, with_lab: bool = False, fails: bool = False) -> str:
        environment = self._environment | ({"FIELDRIG_CONTROL": self._lab_endpoint()} if with_lab else {})
        try:
            done = run_group(["sh", "-e", "-c", self._with_free_ports(command)], self.folder, environment, PATIENCE_S)
        except subprocess.TimeoutExpired as late:
            pytest.fail(f"{block.place}: it does not end: {command}\n{late.output}")
        assert (done.returncode != 0) == fails, f"{block.place}: exit code {done.returncode}: {command}\n{done.stdout}"
        return self._with_known_ports(done.stdout)

    def _lab_endpoint(self) -> str:
        """Return the endpoint of the lab of this page, which is started at its first use."""
        endpoint = f"tcp/127.0.0.1:{self._ports['7447']}"
        if self._lab is not None:
            return endpoint
        options = [f"--control={endpoint}"]
        for key, port in (("buses.can0.socketcand", "29536"), ("buses.mb_tcp.listen", "5020")):
            options += ["--set", f"{key}=127.0.0.1:{self._ports[port]}"]
        with (self.folder / "lab.out").open("wb") as output:
            self._lab = subprocess.Popen(
                [".venv/bin/python3", "-m", "fieldrig", "up", "configs/lab.yaml", *options],
                cwd=self.folder,
                env=self._environment | {"PATH": os.environ["PATH"]},
                stdin=subprocess.DEVNULL,
                stdout=output,
                stderr=subprocess.STDOUT,
            )
        give_up_s = time.monotonic() + PATIENCE_S
        while "ready in" not in (printed := (self.folder / "lab.out").read_text(encoding="utf-8")):
            assert self._lab.poll() is None, printed
            assert time.monotonic() < give_up_s, printed
            time.sleep(0.05)
        return endpoint

    def _with_free_ports(self, text: str) -> str:
        return exchanged(text, self._ports)

    def _with_known_ports(self, text: str) -> str:
        return exchanged(text, self._originals)


@pytest.mark.parametrize("page", PAGES, ids=place_of)
def test_a_page_does_what_it_says(page: Path) -> None:
    found = [*blocks(page)]
    with Desk(found) as desk:
        for block in found:
            desk.try_block(block)
        if desk.missing:
            pytest.skip(f"{', '.join(sorted(set(desk.missing)))} not there; the rest of the page is right")


@pytest.mark.parametrize("page", PAGES, ids=place_of)
def test_a_shell_does_not_wait_for_a_rig_that_has_ended(page: Path) -> None:
    """Once, a block waited 600 s for a rig whose port another program had."""
    waiting = [line for block in blocks(page) for line in block.text.splitlines() if "--ready all" in line]
    assert all("kill -0 $!" in line for line in waiting if line.startswith("until"))


def test_make_lab_is_what_the_pages_are_tried_with() -> None:
    assert "fieldrig up configs/lab.yaml\n" in (ROOT / "Makefile").read_text(encoding="utf-8")


def _transcript(block: Block) -> Iterator[tuple[str, list[str]]]:
    """Each command, and the lines that it must print."""
    command, expected = "", list[str]()
    for line in block.text.splitlines():
        if command.endswith("\\"):
            command = f"{command}\n{line}"
        elif line.startswith(PROMPT):
            if command:
                yield command, expected
            command, expected = line.removeprefix(PROMPT), []
        elif line.strip():
            expected.append(line)
    yield command, expected


def _plain(text: str) -> str:
    """Replace several spaces by one, as the width of columns depends on their content."""
    return "\n".join(" ".join(line.split()) for line in text.splitlines())
