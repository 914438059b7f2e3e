"""The seat of the page: its addresses, and tokens that stay the same where the rig has one."""

import socket
from typing import cast

import pytest

from fieldrig.errors import BusError, RigError
from fieldrig.outside.page_seat import Seat, take_seat
from fieldrig.outside.shared_token import FILE_VARIABLE, TOKEN_VARIABLE

pytestmark = pytest.mark.system


@pytest.fixture(autouse=True)
def no_token(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv(TOKEN_VARIABLE, raising=False)
    monkeypatch.delenv(FILE_VARIABLE, raising=False)


def listener() -> socket.socket:
    return socket.create_server(("127.0.0.1", 0))


class OnIpv6:
    """A socket of a host with IPv6, which the host of the tests need not have."""

    def getsockname(self) -> tuple[str, int, int, int]:
        return "::1", 8372, 0, 0


def test_each_role_has_an_address_with_a_token_of_its_own() -> None:
    with listener() as own:
        seat = Seat(own)
        port = seat.address[1]
        assert seat.addresses() == {
            role: f"http://127.0.0.1:{port}/?token={token}" for role, token in seat.tokens.items()
        }
        assert set(seat.tokens) == {"operate", "look"}
        assert len({*seat.tokens.values(), *Seat(own).tokens.values()}) == 4  # and others at the next start


def test_the_first_further_name_is_the_one_that_is_printed() -> None:
    with listener() as own:
        seat = Seat(own, ("bench-pc:9000", "other:1"), {"look": "t"})
        assert seat.addresses() == {"look": "http://bench-pc:9000/?token=t"}


def test_an_address_of_ipv6_is_in_brackets() -> None:
    seat = Seat(cast(socket.socket, OnIpv6()), (), {"look": "t"})
    assert seat.addresses() == {"look": "http://[::1]:8372/?token=t"}


def test_the_tokens_follow_from_that_of_the_rig_and_do_not_tell_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(TOKEN_VARIABLE, "secret")
    with listener() as own:
        first, again = Seat(own).tokens, Seat(own).tokens
        assert first == again
        assert first["operate"] != first["look"]
        assert "secret" not in "".join(first.values())
        monkeypatch.setenv(TOKEN_VARIABLE, "another")
        assert Seat(own).tokens["look"] != first["look"]


def test_a_seat_survives_the_way_to_another_process() -> None:
    with listener() as own:
        seat = Seat(own, ("bench-pc:9000",))
        copy = Seat.from_text(seat.to_text(), own.dup().detach())
        try:
            assert (copy.tokens, copy.hosts, copy.address) == (seat.tokens, seat.hosts, seat.address)
        finally:
            copy.close()


def test_an_address_that_is_taken_is_refused_with_what_to_do() -> None:
    with listener() as other:
        place = f"127.0.0.1:{other.getsockname()[1]}"
        with pytest.raises(BusError, match="the page cannot listen on") as refused:
            take_seat(place)
        assert "choose another port" in refused.value.remedy


def test_beyond_loopback_a_token_is_needed(monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(RigError, match="can be reached from other machines"):
        take_seat("0.0.0.0:0")
    monkeypatch.setenv(TOKEN_VARIABLE, "secret")
    seat = take_seat("0.0.0.0:0")
    assert seat.addresses()["look"].startswith("http://127.0.0.1:")
    seat.close()
