"""Ports for the rigs of tests: none twice, and none that the system may give to a connection meanwhile."""

import socket
from pathlib import Path

import pytest

from fieldrig import testing
from fieldrig.testing import free_port, return_port


def test_ports_are_different_and_none_of_those_of_connections() -> None:
    ports = [free_port() for _ in range(50)]
    try:
        assert len(set(ports)) == 50
        assert set(ports) <= set(testing.PORTS)
    finally:
        for port in ports:
            return_port(port)


@pytest.mark.parametrize("range_of_connections", ["1024 65535\n", "", "none"])
def test_where_connections_may_have_any_port_the_system_chooses(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, range_of_connections: str
) -> None:
    file = tmp_path / "ip_local_port_range"
    file.write_text(range_of_connections)
    monkeypatch.setattr(testing, "_PORTS_OF_CONNECTIONS", file)
    port = free_port()
    with socket.socket() as listener:
        listener.bind(("127.0.0.1", port))
    return_port(port)


def test_a_port_at_which_something_listens_is_not_free(monkeypatch: pytest.MonkeyPatch) -> None:
    port = free_port()
    return_port(port)
    monkeypatch.setattr(testing, "PORTS", range(port, port + 1))
    with socket.socket() as listener:
        listener.bind(("127.0.0.1", port))
        other = free_port()
    assert other != port
    return_port(other)
