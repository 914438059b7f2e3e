import signal

import addresses
import pytest

if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    # a shell turns it off for what it starts in the background; rigs would take that for the user's wish
    signal.signal(signal.SIGINT, signal.default_int_handler)

pytest.register_assert_rewrite("can_link_laws")  # a suite of tests that has its place in tests/support


@pytest.fixture
def free_port() -> int:
    """A TCP port of 127.0.0.1 that nobody listens on."""
    return addresses.free_port()
