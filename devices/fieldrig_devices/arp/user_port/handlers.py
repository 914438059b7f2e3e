"""What answers a request: data in, data of the answer out, or RequestError or struct.error for the length."""

from collections.abc import Callable, Mapping

from fieldrig_devices.arp.user_port.messages import RequestError, Status

Handler = Callable[[bytes], bytes]
Handlers = Mapping[int, Handler]


def bare(act: Callable[[], bytes]) -> Handler:
    """Of a request without data."""

    def handler(data: bytes) -> bytes:
        if data:
            raise RequestError(Status.LENGTH, "this request has no data")
        return act()

    return handler
