"""An editor's side of the Debug Adapter Protocol, against a program that a test runs."""

from collections.abc import Mapping
from typing import Any

from counting_program import CountingProgram

from fieldrig.clock import VirtualClock
from fieldrig_devices.languages.debugging.adapter import Adapter
from fieldrig_devices.languages.debugging.framing import Framer, framed
from fieldrig_devices.languages.debugging.service import DebugService


class Editor:
    """An editor's side of the protocol."""

    def __init__(self, program: CountingProgram | None = None, service: DebugService | None = None) -> None:
        self.program = program or CountingProgram()
        self.service = service or DebugService(VirtualClock(), self.program)
        self.adapter = Adapter(self.service.answer)
        self._sequence = 0

    def messages(self, command: str, **arguments: Any) -> list[Any]:
        """Send a request, and return all that it is answered with."""
        self._sequence += 1
        message = {"seq": self._sequence, "type": "request", "command": command, "arguments": arguments}
        return read(self.adapter.feed(framed(message)))

    def request(self, command: str, **arguments: Any) -> dict[str, Any]:
        """Send a request, and return the body of its response; an error is returned as its message."""
        response = self.messages(command, **arguments)[-1 if command == "configurationDone" else 0]
        assert (response["type"], response["request_seq"], response["command"]) == ("response", self._sequence, command)
        if not response["success"]:
            return {"error": response["message"]}
        body: dict[str, Any] = response["body"]
        return body

    def events(self) -> list[tuple[str, Mapping[str, Any]]]:
        return [(message["event"], message["body"]) for message in read(self.adapter.poll())]


def read(data: bytes) -> list[Any]:
    return Framer().feed(data)
