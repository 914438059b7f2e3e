import addresses
import pytest

pytest.register_assert_rewrite("can_link_laws")  # a suite of tests that has its place in tests/support


@pytest.fixture
def free_port() -> int:
    """A TCP port of 127.0.0.1 that nobody listens on."""
    return addresses.free_port()
