"""Handlers of requests: each takes data and returns the data of the answer, or raises RequestError or struct.error."""

from collections.abc import Callable, Mapping

from fieldrig_devices.arp.user_port.messages import RequestError, Status

Handler = Callable[[bytes], bytes]
Handlers = Mapping[int, Handler]


def bare(act: Callable[[], bytes]) -> Handler:
    """Make a handler of a request without data."""

    def handler(data: bytes) -> bytes:
        if data:
            raise RequestError(Status.LENGTH, "this request has no data")
        return act()

    return handler
