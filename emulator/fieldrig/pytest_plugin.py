"""Rigs as pytest fixtures.

In virtual time, in the test's own process, ready in milliseconds:

    def test_level_rises(fieldrig_rig):
        rig = fieldrig_rig("rigs/tank.yaml")
        rig.set("drive/run", True)
        rig.run_until(10 * S)
        assert rig.get("tank/level") > 0.1

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
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    from fieldrig.real.live_rig import LiveRig
    from fieldrig.virtual.rig import Rig

RigMaker = Callable[..., "Rig"]
"""The fixture `fieldrig_rig`: makes a rig in virtual time of a file with overrides, or of a dict."""
MasterRigMaker = Callable[..., "Rig | LiveRig"]
"""The fixture `fieldrig_master`: makes a rig of a file with overrides, or of a dict, and the test a master of it."""
LiveRigMaker = Callable[..., "LiveRig"]
"""The fixture `fieldrig_up`: starts a rig file with overrides in real time."""


@pytest.fixture
def fieldrig_rig() -> Iterator[RigMaker]:
    """Makes rigs of files (`str`, `Path`, with overrides such as "seed=3") or of dicts; closes them after the test.

    A file of real time runs in virtual time.
    """
    # Imported here: every pytest run on the machine loads this file, few use it.
    from fieldrig.config.rig_file import from_dict, load
    from fieldrig.virtual.rig import Rig

    with ExitStack() as rigs:

        def make(source: str | Path | dict[str, Any], *overrides: str) -> Rig:
            config = from_dict(source) if isinstance(source, dict) else load(source, (*overrides, "time=virtual"))
            return rigs.enter_context(Rig(config))

        yield make


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.getgroup("fieldrig").addoption(
        "--fieldrig-time",
        choices=("virtual", "real"),
        default="virtual",
        help="the time of tests with fieldrig_master (default: virtual)",
    )


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
