"""Handlers of requests: each takes data and returns the data of the answer, or raises RequestError or struct.error.

None is the result of a request that will be answered later.
"""

from collections.abc import Callable, Mapping

from fieldrig_devices.arp.user_port.messages import RequestError, Status

Handler = Callable[[bytes], bytes | None]
Handlers = Mapping[int, Handler]


def bare(act: Callable[[], bytes | None]) -> Handler:
    """Make a handler of a request without data."""

    def handler(data: bytes) -> bytes | None:
        if data:
            raise RequestError(Status.LENGTH, "this request has no data")
        return act()

    return handler
