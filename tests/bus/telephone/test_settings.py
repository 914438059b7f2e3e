"""Mistakes in the settings of a telephone network: where they are, and what was expected."""

from typing import Any

import pytest

from fieldrig.config.rig_file import from_dict
from fieldrig.errors import ConfigError

MODEM = {"kind": "modem", "links": {"line": "com", "telephone": "net"}}


def mistakes(**net: Any) -> list[str]:
    buses = {"com": {"kind": "serial.line"}, "net": {"kind": "telephone.exchange", "numbers": {"desk": "100"}, **net}}
    try:
        from_dict({"time": "real", "buses": buses, "devices": {"desk": MODEM}})
    except ConfigError as wrong:
        return [f"{mistake.key}: {mistake.what}" for mistake in wrong.mistakes]
    return []


ROWS: list[tuple[dict[str, Any], str]] = [
    ({"numbers": {"dusk": "100"}}, 'buses.net.numbers.dusk: this network has no member "dusk"'),
    ({"faults": [{"what": "cut", "line": "dusk"}]}, 'buses.net.faults[0].line: this network has no member "dusk"'),
    (
        {"outgoing": [{"number": "1001", "dial": "127.0.0.1:1"}]},
        "buses.net: number 1001 of outside 1001 begins with 100 of desk: expected other digits",
    ),
    (
        {"incoming": [{"number": "7", "listen": "127.0.0.1:1"}]},
        "buses.net: incoming.0.number: 7 leads nowhere: expected 100",
    ),
]


@pytest.mark.parametrize(("net", "expected"), ROWS)
def test_a_mistake_is_refused_where_it_is(net: dict[str, Any], expected: str) -> None:
    assert mistakes(**net) == [expected]


@pytest.mark.parametrize(
    "net",
    [
        {"numbers": {"desk": "one"}},
        {"outgoing": [{"number": "5", "dial": "nowhere"}]},
        {"faults": [{"what": "dropout", "period_ms": 100}]},
        {"faults": [{"what": "dropout", "period_ms": 100, "length_ms": 100}]},
        {"faults": [{"what": "noise", "bit_error_rate": 0.6}]},
        {"highest_bps": 56_000},
        {"outside_prefix": "x"},
    ],
)
def test_a_value_that_cannot_be_is_refused(net: dict[str, Any]) -> None:
    assert len(mistakes(**net)) == 1


def test_a_network_without_mistakes_is_taken() -> None:
    way_in = {"number": "100", "listen": "127.0.0.1:1"}
    assert mistakes(incoming=[way_in], outgoing=[{"number": "5", "dial": "127.0.0.1:2", "telnet": True}]) == []
