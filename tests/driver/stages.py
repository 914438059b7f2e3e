"""The stages of the tests: what each runs, and what it needs from the machine.

`needs` must be met or the stage is left out.  `wants` only serve some of its tests, which skip themselves without;
either way the summary says so.
"""

import os
import subprocess
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, contextmanager, nullcontext
from dataclasses import dataclass
from enum import Enum
from functools import cache
from pathlib import Path
from threading import Lock

from tests.driver import docker_daemon, needs, ppp, vcan
from tests.driver.needs import Need

REPORTS = Path("build") / "tests"
BYTECODE = Path("build") / "bytecode"
PRODUCT = ("emulator", "bus", "devices", "page", "configs")
NODE = Path("tests") / "real" / "node"
GUEST_LIMIT_S = 2400
FOREIGN = "tests/real"
BROWSER = "tests/page/browser"
# A test that starts a whole rig, or runs behind others, can wait long for a busy host; its own limits say earlier
# what hangs.
PATIENT = ("--timeout=600",)
COMPILING = Lock()
"""Guests begin at the same time, and the second waits for what the first compiles."""


class Turn(Enum):
    """When a stage runs among those that stand next to it in a plan."""

    ALONE = "it has the host for itself"
    FIRST = "it looks at the sources, beside others that do, and all else waits for them"
    BESIDE = "it shares nothing with others of this kind, so that all of them can run at the same time"
    AFTER = "it waits until those beside each other have ended, and bears those that run behind"
    BEHIND = "nothing in it waits for the host's clock: it runs with what the others leave of the processors"


@dataclass(frozen=True, slots=True)
class Stage:
    name: str
    about: str
    command: Callable[[], list[str]]
    needs: tuple[Need, ...] = ()
    wants: tuple[Need, ...] = ()
    around: Callable[[], AbstractContextManager[Mapping[str, str]]] = lambda: nullcontext({})
    """The context that must be there while the stage runs; it gives variables for its environment."""
    report: Path | None = None
    """JUnit file that its pytest writes."""
    again: Callable[[], list[str]] | None = None
    """The command that repeats only the tests that failed, for a stage whose tests share the host with real time."""
    turn: Turn = Turn.ALONE


def module(*arguments: str) -> Callable[[], list[str]]:
    return lambda: [sys.executable, "-m", *arguments]


def pytest_command(name: str, marks: str, *more: str) -> list[str]:
    return [sys.executable, "-m", "pytest", "-m", marks, f"--junitxml={report_of(name)}", *more]


def only_failed(name: str, marks: str, *more: str) -> list[str]:
    """The tests of the stage that failed in its last run, one after the other."""
    return pytest_command(f"{name}-again", marks, "--last-failed", "--last-failed-no-failures=none", *more)


def report_of(name: str) -> Path:
    return REPORTS / f"{name}.xml"


def marked(mark: str, folder: str = "tests") -> list[str]:
    """The files with tests that have a mark: a stage that names them need not collect all the others."""
    return sorted(str(file) for file in Path(folder).rglob("test_*.py") if f"mark.{mark}" in file.read_text())


def check_stage(name: str, about: str, command: Callable[[], list[str]]) -> Stage:
    return Stage(name, about, command, turn=Turn.FIRST)


def types_elsewhere(platform: str) -> Stage:
    """The types of the product on a system that is not this one; the tests need Linux."""
    options = (f"--platform={platform}", f"--cache-dir=.mypy_cache/{platform}")
    return check_stage(f"types-{platform}", f"mypy --strict for {platform}", module("mypy", *options, *PRODUCT))


def pytest_stage(
    name: str,
    about: str,
    marks: str,
    *more: str,
    needs: tuple[Need, ...] = (),
    wants: tuple[Need, ...] = (),
    around: Callable[[], AbstractContextManager[Mapping[str, str]]] = lambda: nullcontext({}),
    in_real_time: bool = False,
    turn: Turn = Turn.ALONE,
    files: Callable[[], list[str]] = list,
) -> Stage:
    """A stage of the tests with these marks, in all files if `files` names none."""
    again = (lambda: only_failed(name, marks, *PATIENT, *files())) if in_real_time else None
    return Stage(
        name,
        about,
        lambda: pytest_command(name, marks, *more, *files()),
        needs,
        wants,
        around,
        report_of(name),
        again,
        turn,
    )


@cache
def compile_foreign() -> None:
    """Compile the modules of the foreign tests, once for all guests.

    A process in a guest can have some 65,000 pages, which is too little to compile them all.
    """
    files = {*marked("vcan", FOREIGN), *marked("ppp", FOREIGN)}
    collect = [sys.executable, "-m", "pytest", *sorted(files), "--collect-only", "-p", "no:cacheprovider"]
    subprocess.run(collect, stdout=subprocess.DEVNULL, check=False)


def guest_stage(
    name: str,
    about: str,
    guest: Callable[[Sequence[str], Path, float], list[str]],
    *,
    needs: tuple[Need, ...],
    wants: tuple[Need, ...] = (),
    around: Callable[[], AbstractContextManager[Mapping[str, str]]] = lambda: nullcontext({}),
) -> Stage:
    """A stage in user-mode Linux; what it knows of failed tests is in its reports, which alone outlive the guest."""
    where = (*marked(name, FOREIGN), "-o", f"cache_dir={REPORTS / f'{name}-cache'}", *PATIENT)
    command, again = pytest_command(name, name, *where), only_failed(name, name, *where)

    @contextmanager
    def prepared() -> Iterator[Mapping[str, str]]:
        with COMPILING:
            compile_foreign()
        with around() as environment:
            yield environment

    return Stage(
        name,
        about,
        lambda: guest(command, REPORTS, GUEST_LIMIT_S),
        needs,
        wants,
        prepared,
        report_of(name),
        lambda: guest(again, REPORTS, GUEST_LIMIT_S),
        turn=Turn.BESIDE,
    )


@contextmanager
def node_packages() -> Iterator[Mapping[str, str]]:
    """The CANopen master from npm, if npm is there to fetch and build it; kept until its lock file changes."""
    lock, installed = NODE / "package-lock.json", NODE / "node_modules" / ".package-lock.json"
    is_fresh = installed.exists() and installed.stat().st_mtime >= lock.stat().st_mtime
    if not is_fresh and needs.NPM.is_met():
        # Debian's headers for the C++ parts; without them node-gyp would fetch them.
        headers = {"npm_config_nodedir": "/usr"} if Path("/usr/include/node/node.h").exists() else {}
        subprocess.run(["npm", "ci", "--no-audit", "--no-fund"], cwd=NODE, env={**os.environ, **headers}, check=False)
    yield {}


ELSEWHERE = tuple(types_elsewhere(platform) for platform in ("win32", "darwin"))
CHECKS = (
    check_stage("format", "the code is formatted", module("ruff", "format", "--check")),
    check_stage("lint", "ruff has nothing to say", module("ruff", "check", "--quiet")),
    check_stage("types", "mypy --strict", module("mypy")),
    *ELSEWHERE,
    check_stage("prose", "docs and messages use the project's English", module("tests.driver.prose")),
    check_stage(
        "imports",
        "devices stand on buses, buses on the kernel",
        lambda: [str(Path(sys.prefix) / "bin" / "lint-imports"), "--no-logo"],
    ),
)

IN_MEMORY = "not system and not real and not docker"
FORKED = ("-p", "tests.driver.forks", "--forks")
# By default a signal ends a test that hangs, once: hypothesis then tries the same again, and hangs.
ON_ALL_CORES = (*FORKED, "--timeout-method=thread")
UNIT = pytest_stage(
    "unit",
    "in memory and in virtual time",
    f"{IN_MEMORY} and not lean",
    *ON_ALL_CORES,
    *PATIENT,
    turn=Turn.BEHIND,
)
# In a process with the modules of all tests a branch takes 2 to 5 times as long, a block of `virtual_time` 1.5 times.
LEAN = pytest_stage(
    "lean",
    "in a process without all other tests",
    f"{IN_MEMORY} and lean",
    *ON_ALL_CORES,
    *PATIENT,
    turn=Turn.BEHIND,
    files=lambda: marked("lean"),
)
FEW_EXAMPLES = "--hypothesis-profile=quick"
# What has become slow is named, so that it gets the mark `long`.
SLOWEST = ("--durations=5", "--durations-min=0.5")
QUICK = pytest_stage(
    "quick",
    "in memory, but what takes long",
    f"{IN_MEMORY} and not long and not lean",
    *ON_ALL_CORES,
    FEW_EXAMPLES,
    *SLOWEST,
)

WHOLE = (
    pytest_stage(
        "docker",
        "the containers",
        "docker",
        "tests/docker",
        *PATIENT,
        needs=(needs.DOCKER,),
        around=docker_daemon.reachable,
        in_real_time=True,
        turn=Turn.AFTER,  # it waits for images and containers more than half of its time
    ),
    guest_stage(
        "vcan",
        "foreign peers on the kernel's CAN",
        vcan.command,
        needs=(needs.VCAN,),
        wants=(needs.CAN_UTILS, needs.NPM),
        around=node_packages,
    ),
    guest_stage("ppp", "pppd at the other end of our links", ppp.command, needs=(needs.UML, needs.PPPD)),
    pytest_stage(
        "real",
        "foreign peers on sockets and ptys",
        "real and not vcan and not ppp",
        FOREIGN,
        BROWSER,
        *PATIENT,
        wants=(
            needs.CHROMIUM,
            needs.NPM,
            needs.CAN_UTILS,
            needs.MBPOLL,
            needs.SOCAT,
            needs.TSHARK,
            needs.GTKWAVE,
            needs.SIGROK,
            needs.LIBMODBUS,
            needs.CHAT,
            needs.TNFTP,
        ),
        in_real_time=True,
        turn=Turn.BESIDE,  # most of its time it waits for its peers
    ),
    LEAN,
    UNIT,
    pytest_stage(
        "system",
        "processes, sockets, ptys",
        "system and not real and not docker",
        *FORKED,
        *PATIENT,
        wants=(needs.UML, needs.MBPOLL, needs.NODE),
        in_real_time=True,
        turn=Turn.AFTER,  # half of the processors' time is left over, as its tests wait for their processes
        files=lambda: marked("system"),
    ),
)

BENCH = Stage(
    "bench", "speed, beside peers", lambda: [sys.executable, str(Path("tests") / "bench")], wants=(needs.LIBMODBUS,)
)

PLANS: Mapping[str, tuple[Stage, ...]] = {
    "check": CHECKS,
    "fast": (*(stage for stage in CHECKS if stage not in ELSEWHERE), QUICK),
    "test": (*CHECKS, *WHOLE),
    "bench": (BENCH,),
}
STAGES: Mapping[str, Stage] = {stage.name: stage for stage in PLANS["test"]}
