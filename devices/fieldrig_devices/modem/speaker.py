"""The echo, result codes and texts that a modem writes to its terminal, as E, Q, V, W and X say."""

from collections.abc import Callable

from fieldrig_bus.telephone.modulation import Agreed
from fieldrig_devices.modem import results
from fieldrig_devices.modem.profile import Profile
from fieldrig_devices.modem.results import Result


class Speaker:
    def __init__(self, write: Callable[[bytes], None], profile: Callable[[], Profile]) -> None:
        self._write, self._profile = write, profile
        self.is_answering = False
        """The present call, or the last one, came from outside; Q2 says nothing of it."""

    def echo(self, data: bytes) -> None:
        if self._profile().settings["E"]:
            self._write(data)

    def tell(self, result: Result) -> None:
        quiet = self._profile().settings["Q"]
        if quiet == 0 or (quiet == 2 and not self.is_answering):
            self._write(results.written(result, self._is_verbose, *self._ends()))

    def tell_connected(self, agreed: Agreed, baud: int) -> None:
        """Write the results of a call that is connected; `baud` is the rate of the serial line.

        The reports are in the order of V.250, 6.4.2 to 6.6.2: modulation, error correction, compression, serial line.
        """
        parameters = self._profile().parameters
        reports = {
            "+MR": results.modulation(agreed),
            "+ER": (results.correction(agreed),),
            "+DR": (results.NO_COMPRESSION,),
            "+ILRR": (results.local_rate(baud),),
        }
        for name, report in reports.items():
            for result in report if parameters[name][0] else ():
                self.tell(result)
        if self._profile().settings["W"] == 1:
            self.tell(results.carrier(agreed.bps))
            self.tell(results.PROTOCOL[agreed.is_corrected])
        self.tell_rate(agreed, baud)

    def tell_rate(self, agreed: Agreed, baud: int) -> None:
        settings = self._profile().settings
        self.tell(results.connect(agreed.bps if settings["W"] == 2 else baud, settings["X"] > 0))

    def write_text(self, text: str) -> None:
        self._write(results.text_written(text, self._is_verbose, *self._ends()))

    @property
    def _is_verbose(self) -> bool:
        return bool(self._profile().settings["V"])

    def _ends(self) -> tuple[bytes, bytes]:
        registers = self._profile().registers
        return bytes((registers[3],)), bytes((registers[4],))
