"""Limits of callers: each is a line of the log and a figure of the controller, as at the ports of buses."""

import logging
from collections.abc import Callable

import pytest
from dial_in_bench import CONTROLLER, DialInBench

from fieldrig.outside.limits import OVER_LIMIT
from fieldrig_devices.connections.connection import TOO_LONG
from fieldrig_devices.connections.stack_services import EXTRA_PORTS
from fieldrig_devices.ftp.server import TOO_MANY_FAILURES
from fieldrig_devices.ip.stack import MOST_HALF_OPEN
from fieldrig_devices.ip.tcp.segment import SYN, Segment

FTP = {"user_name": "lab", "password": "secret"}


def _three_wrong_logins(bench: DialInBench) -> None:
    control, heard = bench.connect(21)
    for _ in range(3):
        bench.ask(control, heard, "USER lab\r\nPASS wrong")
        bench.go(12_000)


def _a_long_command(bench: DialInBench) -> None:
    control, heard = bench.connect(21)
    bench.ask(control, heard, "USER " + "x" * 2000)


def _a_long_head(bench: DialInBench) -> None:
    connection, _ = bench.connect(80)
    connection.send(b"GET / HTTP/1.1\r\nHost: plc\r\nX: " + b"x" * 20_000)
    bench.go(15_000)


def _half_open_connections(bench: DialInBench) -> None:
    bench.connect(80)
    assert bench.stack is not None
    for port in range(2000, 2000 + MOST_HALF_OPEN + 3):
        bench.stack._send_segment(CONTROLLER, Segment(port, 80, 1, 0, SYN, 1024))
    bench.go(3000)


def _too_many_extra_ports(bench: DialInBench) -> None:
    for _ in range(len(EXTRA_PORTS) + 1):
        control, heard = bench.connect(21)
        bench.ask(control, heard, "USER lab\r\nPASS secret\r\nEPSV")


@pytest.mark.long
@pytest.mark.parametrize(
    ("deed", "limit"),
    [
        (_three_wrong_logins, TOO_MANY_FAILURES),
        (_a_long_command, TOO_LONG),
        (_a_long_head, TOO_LONG),
        (_half_open_connections, OVER_LIMIT),
        (_too_many_extra_ports, OVER_LIMIT),
    ],
)
def test_a_limit_that_a_caller_reaches_is_counted_and_logged(
    deed: Callable[[DialInBench], None], limit: str, caplog: pytest.LogCaptureFixture
) -> None:
    bench = DialInBench(ftp=FTP).call()
    assert bench.max4.limits_reached() == {}
    with caplog.at_level(logging.WARNING):
        deed(bench)
    assert bench.max4.limits_reached().get(limit, 0) >= 1
    assert [line for line in caplog.messages if line.startswith("calls at COM1: ") and limit in line]
