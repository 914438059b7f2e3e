"""Reports, which become a line of the log, and a diagnosis of the axis and of the controller.

Source: PacDrive manual 4163-4196, 4206-4210, 4317-4337 (digest PD-091 to PD-100).  The class of each code can be
changed; a message of class 8 or more is only logged.  The DiagExtCode of a report by a drive is `ring address.1 code`,
our reading of `3.1 1117` (digest 3.2).  DiagMsg on the controller names the axis, in German as on the screen in the
manual, in English as in its prose.
"""

import logging
from collections.abc import Callable, Mapping
from typing import Literal

from fieldrig_devices.max4.axes.axis import Axis
from fieldrig_devices.max4.messages.catalogue import message_of
from fieldrig_devices.max4.messages.diagnosis import MESSAGE_CLASS, Diagnosis, Pending, Sender
from fieldrig_devices.max4.messages.logger import Logger

log = logging.getLogger(__name__)

Language = Literal["de", "en"]
SUB_UNIT = 1


class Reports:
    """The reports of one controller."""

    def __init__(
        self, logger: Logger, language: Language, classes: Mapping[int, int], on_change: Callable[[], None]
    ) -> None:
        """`classes` contains changed classes by default code; otherwise the class is the first digit of the code."""
        self._logger, self.language, self._classes = logger, language, classes
        self.diagnosis = Diagnosis(on_change)

    def code_of(self, code: int) -> int:
        """The code as it is shown, with its class."""
        return self._classes.get(code, code // 1000) * 1000 + code % 1000

    def report(self, code: int, sender: Sender, ext: str = "") -> None:
        """Take a report of the controller, one of its parts, or the program."""
        shown = self._log(code, sender, ext)
        if shown // 1000 < MESSAGE_CLASS:
            message = message_of(code)
            self.diagnosis.add(Pending(shown, ext, self._msg(sender, self._text(code)), message.is_quittable))

    def is_pending(self, code: int, sender: Sender) -> bool:
        """True if this report of the sender has not been acknowledged yet."""
        shown, msg = self.code_of(code), self._msg(sender, self._text(code))
        return any((pending.code, pending.msg) == (shown, msg) for pending in self.diagnosis.pending)

    def withdraw(self, code: int) -> None:
        """Remove a report that cannot be acknowledged, because its cause has been ended."""
        self.diagnosis.withdraw(self.code_of(code))

    def report_axis(self, code: int, axis: Axis, ext: str = "", *, is_logged: bool = True) -> None:
        """Take a report of or about a drive.  `code` is a default code or that of the drive; `ext` is logged."""
        shown = self._log(code, axis.sender, ext) if is_logged else self.code_of(code)
        if shown // 1000 < MESSAGE_CLASS:
            text, is_quittable = self._text(code), message_of(code).is_quittable
            ext_code = f"{axis.ring_address}.{SUB_UNIT} {shown}"
            axis.diagnosis.add(Pending(shown, ext_code, text, is_quittable))
            if is_logged:
                self.diagnosis.add(Pending(shown, ext_code, self._msg(axis.sender, text), is_quittable))

    def _log(self, code: int, sender: Sender, ext: str) -> int:
        shown = self.code_of(code)
        if shown // 1000 < MESSAGE_CLASS:
            log.info("diagnosis %d: %s %s", shown, self._msg(sender, self._text(code)), ext)
        self._logger.insert(message_of(code).type, sender, shown, ext, self._text(code))
        return shown

    def _text(self, code: int) -> str:
        message = message_of(code)
        return message.de if self.language == "de" else message.en

    def _msg(self, sender: Sender, text: str) -> str:
        if self.language == "de":
            return f"{sender.object}.{sender.instance} {text}"
        return f"{sender.object.replace('_', '-')}/{sender.instance}: {text}"
