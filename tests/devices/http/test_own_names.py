"""The names by which a device answers."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fieldrig_devices.http.own_names import is_own


@pytest.mark.parametrize(
    "host",
    ["127.0.0.1", "127.0.0.1:8080", "192.168.1.5", "[::1]", "[::1]:8080", "[fe80::1%eth0]", "localhost", "localhost:80",
     "LOCALHOST", "localhost.", "plc", "machine:8080", "plc.localhost"],
)  # fmt: skip
def test_a_name_that_no_stranger_can_give_an_address_is_own(host: str) -> None:
    assert is_own(host)


@pytest.mark.parametrize(
    "host",
    ["evil.example", "127.0.0.1.evil.example", "plc.evil.example:8080", "localhost.evil.example", "1.2.3.4.5",
     "user@127.0.0.1", "127.0.0.1:port", "127.0.0.1/x", "a b", "[::1", "127.0.0.1:99999", ""],
)  # fmt: skip
def test_any_other_name_is_not(host: str) -> None:
    assert not is_own(host)


def test_a_configured_name_is_own() -> None:
    assert is_own("plc.example.org:8080", ["PLC.example.org"])
    assert not is_own("other.example.org", ["plc.example.org"])


@given(st.text(max_size=40))
def test_anything_has_an_answer(host: str) -> None:
    is_own(host)
