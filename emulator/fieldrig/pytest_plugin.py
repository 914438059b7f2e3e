"""Rigs as pytest fixtures.

In virtual time, in the test's own process, ready in milliseconds:

    def test_level_rises(fieldrig_rig):
        rig = fieldrig_rig("rigs/tank.yaml")
        rig.set("drive/run", True)
        rig.run_until(10 * S)
        assert rig.get("tank/level") > 0.1

A rig that takes long to come up, booted once a session; each test has a branch of it (Linux and macOS):

    def test_feeder_runs(fieldrig_branch):
        feeder = fieldrig_branch("configs/feeder.yaml", boot=10 * S)
        feeder.set("feeder/panel.key1", True)
        feeder.run_for(5 * S)

A program alone, compiled once a session; each test begins with fresh variables at the time 0:

    def test_pid_holds(fieldrig_program):
        plc = fieldrig_program("pid.st")
        pid = plc.block("PID")
        pid(setpoint=50.0)
        plc.advance(10 * MS)

A master in virtual time, unchanged: the test itself, and all threads that it starts, are in the time of the rig:

    def test_homing(fieldrig_master):
        rig = fieldrig_master("axes.yaml")
        my_machine.home(host="127.0.0.1", port=29536)  # an address of the rig file
        assert rig.now_ns < 70 * S

With `--fieldrig-time=real` these tests run in real time, against `fieldrig up`.

In real time, in processes of their own, for masters with a clock of their own:

    @pytest.fixture(scope="session")
    def modbus(fieldrig_up):
        port = free_port()
        fieldrig_up("rigs/tank-real.yaml", f"buses.mb_tcp.listen=127.0.0.1:{port}")
        return port
"""

import json
import os
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from sysconfig import get_paths
from tempfile import TemporaryDirectory
from types import FrameType
from typing import TYPE_CHECKING, Any, cast

import pytest

from fieldrig.coverage.folder import FOLDER_VARIABLE

if TYPE_CHECKING:
    from fieldrig.coverage.wanted import Wanted
    from fieldrig.programs import ProgramBench
    from fieldrig.real.live_rig import LiveRig
    from fieldrig.virtual.branch import Branch
    from fieldrig.virtual.rig import Rig

Boot = int | Callable[["Rig"], object]
RigMaker = Callable[..., "Rig"]
"""The fixture `fieldrig_rig`: makes a rig in virtual time of a file with overrides, or of a dict."""
BranchMaker = Callable[..., "Branch"]
"""The fixture `fieldrig_branch`: makes a branch of a rig that a session boots once."""
ProgramMaker = Callable[..., "ProgramBench"]
"""The fixture `fieldrig_program`: makes a program under test of source files, with fresh variables."""
MasterRigMaker = Callable[..., "Rig | LiveRig"]
"""The fixture `fieldrig_master`: makes a rig of a file with overrides, or of a dict, and the test a master of it."""
LiveRigMaker = Callable[..., "LiveRig"]
"""The fixture `fieldrig_up`: starts a rig file with overrides in real time."""


@pytest.fixture
def fieldrig_rig() -> Iterator[RigMaker]:
    """Makes rigs of files (`str`, `Path`, with overrides such as "seed=3") or of dicts; closes them after the test.

    A file of real time runs in virtual time.
    """
    with ExitStack() as rigs:

        def make(source: str | Path | dict[str, Any], *overrides: str) -> "Rig":
            return rigs.enter_context(_rig_of(source, overrides))

        yield make


def _rig_of(source: str | Path | dict[str, Any], overrides: tuple[str, ...]) -> "Rig":
    # Imported here: every pytest run on the machine loads this file, few use it.
    from fieldrig.config.rig_file import from_dict, load
    from fieldrig.virtual.rig import Rig

    return Rig(from_dict(source) if isinstance(source, dict) else load(source, (*overrides, "time=virtual")))


def _booted(source: str | Path | dict[str, Any], overrides: tuple[str, ...], boot: Boot) -> "Rig":
    from fieldrig.virtual.branches import warm

    rig = _rig_of(source, overrides)
    rig.trace_hash()
    if callable(boot):
        boot(rig)
    else:
        rig.run_until(boot)
    warm(rig)
    return rig


@pytest.fixture(scope="session")
def _fieldrig_booted() -> Iterator[Callable[..., "Rig"]]:
    """Boots each rig once, with its overrides and its boot, and keeps it to the end of the session."""
    with ExitStack() as rigs:
        booted: dict[Any, Rig] = {}

        def boot_of(source: str | Path | dict[str, Any], overrides: tuple[str, ...], boot: Boot) -> "Rig":
            name = json.dumps(source, default=str) if isinstance(source, dict) else str(Path(source).absolute())
            if (name, overrides, boot) not in booted:
                booted[name, overrides, boot] = rigs.enter_context(_booted(source, overrides, boot))
            return booted[name, overrides, boot]

        yield boot_of


@pytest.fixture
def fieldrig_branch(_fieldrig_booted: Callable[..., "Rig"]) -> Iterator[BranchMaker]:
    """Makes branches of rigs, sources as for `fieldrig_rig`, and closes them after the test.

    A rig is booted once a session: `boot` is the instant to which it runs, or a function of a module that takes it.
    Where the system has no fork, each test has a rig of its own with the same calls.
    """
    with ExitStack() as branches:

        def make(source: str | Path | dict[str, Any], *overrides: str, boot: Boot = 0) -> "Branch":
            if not hasattr(os, "fork"):
                return cast("Branch", branches.enter_context(_booted(source, overrides, boot)))  # it has the same calls
            return branches.enter_context(_fieldrig_booted(source, overrides, boot).branch())

        yield make


_REPORTS = (
    ("--fieldrig-coverage-data", "FILE", "for `fieldrig coverage`, which adds up runs"),
    ("--fieldrig-lcov", "FILE", "as LCOV"),
    ("--fieldrig-cobertura", "FILE", "as Cobertura"),
    ("--fieldrig-coverage-html", "FOLDER", "as a page with the source"),
)
"""The reports of coverage."""
_PYTHON = {get_paths()[name] for name in ("stdlib", "platstdlib", "purelib", "platlib")}
"""The folders with what Python and its packages have."""
_COVERAGE = pytest.StashKey["_Covering"]()
_PROGRAMS = pytest.StashKey[list["ProgramBench"]]()
"""The programs of a test, for its report."""


@pytest.fixture(scope="session")
def _fieldrig_programs() -> dict[Any, list["ProgramBench"]]:
    """The programs that a session has compiled, by their files and options; several of one if a test takes several."""
    return {}


@pytest.fixture
def fieldrig_program(
    request: pytest.FixtureRequest, _fieldrig_programs: dict[Any, list["ProgramBench"]]
) -> ProgramMaker:
    """Makes programs of source files, with the options of `fieldrig.program`, and compiles each once a session.

    If the test fails, its report has the last changes of their variables.
    """
    used: dict[Any, int] = {}
    mine = request.node.stash.setdefault(_PROGRAMS, [])

    def make(*files: str | Path, **options: Any) -> "ProgramBench":
        from fieldrig.programs import program

        stamps = tuple(_stamp(Path(file)) for file in files)
        key = (stamps, tuple(sorted(options.items())))
        known, number = _fieldrig_programs.setdefault(key, []), used.get(key, 0)
        used[key] = number + 1
        if number == len(known):
            known.append(program(*files, **options))
        else:
            known[number].reset()
        mine.append(known[number])
        return known[number]

    return make


def _stamp(path: Path) -> tuple[str, tuple[int, ...]]:
    """Return what tells a file, or a folder with its files, from a later version of it."""
    inside = sorted(path.rglob("*")) if path.is_dir() else [path]
    return str(path.absolute()), tuple(file.stat().st_mtime_ns for file in inside if file.is_file())


@pytest.hookimpl(hookwrapper=True)
def pytest_runtest_makereport(item: pytest.Item, call: pytest.CallInfo[None]) -> Iterator[None]:
    """Add what happened in the programs of a failed test to its report, which ends at the line of the test."""
    if call.excinfo is not None and not item.config.getoption("fulltrace"):
        _end_at_test(call.excinfo.value)
    outcome: Any = yield
    report = outcome.get_result()
    if report.failed:
        for bench in item.stash.get(_PROGRAMS, []):
            told = bench.told()
            if told:
                report.sections.append(("last changes of the program", told))


def _end_at_test(raised: BaseException) -> None:
    """Leave out of a traceback what fieldrig does to say what is wrong outside it: its message has all of that."""
    from fieldrig.errors import RigError

    last, frames = None, raised.__traceback__
    while frames is not None:
        if not _is_ours_or_python(frames.tb_frame):
            last = frames
        frames = frames.tb_next
    if isinstance(raised, RigError) and last is not None:
        last.tb_next = None
        raised.__cause__ = None
        raised.__suppress_context__ = True


def _is_ours_or_python(frame: FrameType) -> bool:
    name = str(frame.f_globals.get("__name__", ""))
    file = Path(frame.f_code.co_filename)
    return name.startswith("fieldrig") or any(file.is_relative_to(folder) for folder in _PYTHON)


def pytest_addoption(parser: pytest.Parser) -> None:
    group = parser.getgroup("fieldrig")
    group.addoption(
        "--fieldrig-time",
        choices=("virtual", "real"),
        default="virtual",
        help="the time of tests with fieldrig_master (default: virtual)",
    )
    group.addoption(
        "--fieldrig-coverage",
        action="store_true",
        help="show which statements and branches of programs, alone and in rigs, the tests run",
    )
    group.addoption(
        "--fieldrig-coverage-detail",
        action="store_true",
        help="count conditions, MC/DC and the states of enumerations in this coverage too",
    )
    for option, metavar, about in _REPORTS:
        group.addoption(option, type=Path, metavar=metavar, help=f"write this coverage {about}")
    group.addoption(
        "--fieldrig-fail-under", type=float, metavar="PERCENT", help="fail if the coverage of programs is less"
    )


class _Covering:
    """The coverage of a session.  Other processes of it, as those of xdist, find its folder in their environment."""

    def __init__(self, wanted: "Wanted", *, is_detailed: bool) -> None:
        from fieldrig.coverage.collecting import collecting

        self.wanted = wanted
        self.stack = ExitStack()
        self.collector = self.stack.enter_context(collecting(is_detailed=is_detailed))


def pytest_configure(config: pytest.Config) -> None:
    """Let programs have marks from now on, if coverage is wanted."""
    files = [config.getoption(option) for option, _, _ in _REPORTS]
    least = config.getoption("--fieldrig-fail-under")
    is_detailed = config.getoption("--fieldrig-coverage-detail")
    is_wanted = (
        is_detailed or config.getoption("--fieldrig-coverage") or any(one is not None for one in (*files, least))
    )
    if is_wanted and not hasattr(config, "workerinput"):
        from fieldrig.coverage.wanted import Wanted

        config.stash[_COVERAGE] = covering = _Covering(
            Wanted(files[0], files[1], files[2], files[3], least), is_detailed=is_detailed
        )
        config.add_cleanup(covering.stack.close)


@pytest.hookimpl(hookwrapper=True)
def pytest_runtest_teardown() -> Iterator[None]:
    """Note what a test has run behind it, as a process of xdist, or one that was forked, may end without a word."""
    yield
    if FOLDER_VARIABLE in os.environ:
        from fieldrig.coverage import collecting

        collecting.flush()


@pytest.hookimpl(trylast=True)
def pytest_sessionfinish(session: pytest.Session) -> None:
    """Write the reports of coverage, and fail if there is too little."""
    covering = session.config.stash.get(_COVERAGE, None)
    if covering is not None:
        from fieldrig.coverage.summary import Coverage

        coverage = Coverage(covering.collector.news())
        covering.wanted.write(coverage)
        if covering.wanted.shortfall(coverage) and session.exitstatus == pytest.ExitCode.OK:
            session.exitstatus = pytest.ExitCode.TESTS_FAILED


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter, config: pytest.Config) -> None:
    covering = config.stash.get(_COVERAGE, None)
    if covering is not None:
        from fieldrig.coverage.reports.table import table
        from fieldrig.coverage.summary import Coverage

        coverage = Coverage(covering.collector.news())
        terminalreporter.section("coverage of programs")
        for line in table(coverage):
            terminalreporter.write_line(line)
        if shortfall := covering.wanted.shortfall(coverage):
            terminalreporter.write_line(shortfall, red=True)


@pytest.fixture
def fieldrig_master(request: pytest.FixtureRequest) -> Iterator[MasterRigMaker]:
    """Makes a rig of a file (`str`, `Path`, with overrides) or of a dict, and puts the test into its virtual time.

    Options by name are those of `virtual_time`.  With `--fieldrig-time=real` the rig file runs in real time instead.
    """
    with ExitStack() as rigs:

        def make(source: str | Path | dict[str, Any], *overrides: str, **options: Any) -> "Rig | LiveRig":
            if request.config.getoption("--fieldrig-time") == "real":
                return rigs.enter_context(_live(source, overrides, rigs))
            return rigs.enter_context(_in_virtual_time(source, overrides, options))

        yield make


@contextmanager
def _in_virtual_time(
    source: str | Path | dict[str, Any], overrides: tuple[str, ...], options: dict[str, Any]
) -> Iterator["Rig"]:
    from fieldrig.config.rig_file import from_dict, load
    from fieldrig.master_time.block import virtual_time
    from fieldrig.virtual.rig import Rig

    if isinstance(source, dict):
        config = from_dict({**source, "time": "virtual"})
    else:
        config = load(source, (*overrides, "time=virtual"))
    with Rig(config) as rig, virtual_time(rig, **options):
        yield rig


def _live(source: str | Path | dict[str, Any], overrides: tuple[str, ...], rigs: ExitStack) -> "LiveRig":
    from fieldrig.real.live_rig import LiveRig

    if isinstance(source, dict):
        file = Path(rigs.enter_context(TemporaryDirectory(prefix="rig"))) / "rig.yaml"
        file.write_text(json.dumps(source, default=str), encoding="utf-8")  # JSON is YAML
        source = file
    return LiveRig(source, *overrides, "time=real")


@pytest.fixture(scope="session")
def fieldrig_up() -> Iterator[LiveRigMaker]:
    """Starts rig files (`str`, `Path`, with overrides) in real time, and returns each when it is ready.

    Each has a control endpoint and a run folder of its own, so parallel workers don't meet; they end with the session.
    """
    from fieldrig.real.live_rig import LiveRig

    with ExitStack() as rigs:

        def start(file: str | Path, *overrides: str) -> LiveRig:
            return rigs.enter_context(LiveRig(file, *overrides))

        yield start
