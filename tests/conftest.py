import signal

import addresses
import pytest

# What a shell, or nohup, turns off for what it starts in the background rigs would take for the user's wish.
for name, handler in (("SIGINT", signal.default_int_handler), ("SIGHUP", signal.SIG_DFL)):
    number = getattr(signal, name, None)
    if number is not None and signal.getsignal(number) is signal.SIG_IGN:
        signal.signal(number, handler)

pytest.register_assert_rewrite("can_link_laws")  # a suite of tests that has its place in tests/support


@pytest.fixture
def free_port() -> int:
    """A TCP port of 127.0.0.1 that nobody listens on."""
    return addresses.free_port()
