"""The characters that a receiver reads when they were sent in another format: the line's bits, sampled at its own rate.

The receiver looks for the start bit (a falling edge), samples each bit in its middle, and accepts the character
regardless of parity and stop bits, as a UART hands it over with an error flag.  Each chunk of bytes is sampled by
itself.
"""

from fieldrig_bus.serial.message import Format


def garbled(data: bytes, sent_as: Format, received_as: Format) -> bytes:
    return _sampled(_levels(data, sent_as), sent_as.baud, received_as)


def _levels(data: bytes, form: Format) -> list[int]:
    """Levels of the line, one per bit time, least significant data bit first, with an idle character at the end."""
    levels: list[int] = []
    for character in data:
        bits = [character >> bit & 1 for bit in range(form.data_bits)]
        parity = {"N": [], "E": [sum(bits) & 1], "O": [1 - (sum(bits) & 1)]}[form.parity]
        levels += [0, *bits, *parity, *[1] * form.stop_bits]
    return levels


def _sampled(levels: list[int], baud: int, form: Format) -> bytes:
    """Characters in the levels.  Positions are multiples of 1 / (2 * baud * form.baud) s, so they are integers."""
    half_bit, sent_bit = baud, 2 * form.baud
    end = len(levels) * sent_bit

    def level(position: int) -> int:
        return levels[position // sent_bit] if position < end else 1

    received = bytearray()
    position, before = 0, 1
    while position < end:
        now = level(position)
        if before and not now:
            middles = [position + half_bit * (3 + 2 * bit) for bit in range(form.data_bits)]
            received.append(sum(level(middle) << bit for bit, middle in enumerate(middles)))
            stop = position + half_bit * (1 + 2 * (form.bits_per_character - form.stop_bits))
            position, before = stop, level(stop)
        else:
            position, before = (position // sent_bit + 1) * sent_bit, now
    return bytes(received)
