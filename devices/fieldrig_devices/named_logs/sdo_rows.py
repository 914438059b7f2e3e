"""SDO transfers as rows: one line for each read or write, whatever number of segments it took."""

from functools import partial
from typing import Any, Final

from fieldrig.traces.instants import span
from fieldrig.traces.trace import TraceEntry
from fieldrig_devices.canopen.abort import NAMES
from fieldrig_devices.canopen.dictionary import Dictionary
from fieldrig_devices.canopen.names import CanopenNames
from fieldrig_devices.canopen.sdo_names import object_words, value_words
from fieldrig_devices.dialogues import SdoTransfer
from fieldrig_devices.named_logs.parameter_words import parameter_words
from fieldrig_devices.named_logs.row import Row

LONGEST_SHOWN: Final = 80
"""Characters of a content that are shown; scripts get it whole."""
RESPONSE_DISTANCE: Final = 0x80
"""The default identifier of answers is this much below that of requests."""


def sdo_row(transfer: SdoTransfer, first: TraceEntry, names: CanopenNames) -> Row:
    """Return the row of a transfer; `first` is its first message."""
    verb = "write" if transfer.is_download else "read"
    services = ("sdo", verb, *_outcome(transfer))
    dictionary = names.dictionary(transfer.node_id)
    return Row(
        transfer.begin_ns,
        transfer.bus,
        first.family,
        first.sender,
        services,
        f"SDO {verb}",
        names.name(transfer.node_id),
        _text(transfer, dictionary),
        transfer.entries,
        transfer.end_ns,
        transfer.data,
        (transfer.node_id,),
        _identifiers(transfer),
        details=partial(_details, transfer, dictionary),
    )


def _outcome(transfer: SdoTransfer) -> tuple[str, ...]:
    if transfer.abort is not None:
        return ("abort",)
    return () if transfer.is_done else ("unanswered",)


def _identifiers(transfer: SdoTransfer) -> tuple[int, ...]:
    request = transfer.request_id
    return (request, request - RESPONSE_DISTANCE) if request == 0x600 + transfer.node_id else (request,)


def _text(transfer: SdoTransfer, dictionary: Dictionary | None) -> str:
    words = object_words(dictionary, transfer.index, transfer.subindex)
    value = _value(transfer, dictionary)
    if value:
        words += f" = {value}"
    if transfer.abort is not None:
        words += (
            f": aborted by {'the client' if transfer.abort_by_client else 'the node'}, {abort_words(transfer.abort)}"
        )
    elif not transfer.is_done:
        words += ": no answer"
    if transfer.end_ns is not None:
        words += f", {_form(transfer)}in {span(transfer.end_ns - transfer.begin_ns)}"
    return f"{words} ({transfer.wrong})" if transfer.wrong else words


def _value(transfer: SdoTransfer, dictionary: Dictionary | None) -> str:
    data = transfer.data
    if data is None or (transfer.is_download is False and not transfer.is_done):
        return ""
    if not data:
        return "empty"
    parameter = parameter_words(transfer.index, transfer.subindex, data)
    words = parameter or value_words(dictionary, transfer.index, transfer.subindex, data)
    return words if len(words) <= LONGEST_SHOWN else f"{words[:LONGEST_SHOWN]} …"


def _form(transfer: SdoTransfer) -> str:
    if transfer.form == "expedited" or transfer.abort is not None or transfer.data is None:
        return ""
    way = "in blocks" if transfer.form == "block" else "in segments"
    return f"{len(transfer.data)} bytes {way} "


def abort_words(code: int) -> str:
    """Return `0602 0000h no object`."""
    words = NAMES.get(code, "unknown code").lower().replace("_", " ")
    return f"{code >> 16:04X} {code & 0xFFFF:04X}h {words}"


def _details(transfer: SdoTransfer, dictionary: Dictionary | None) -> dict[str, Any]:
    variable = None if dictionary is None else dictionary.get(transfer.index, transfer.subindex)
    return {
        "index": transfer.index,
        "subindex": transfer.subindex,
        "object": "" if variable is None else variable.name,
        "value": _value(transfer, dictionary),
        "form": transfer.form,
        "abort": transfer.abort,
        "abort_by_client": transfer.abort_by_client,
        "is_done": transfer.is_done,
        "wrong": transfer.wrong,
    }
