"""The characters that a receiver reads from a line that disturbs them: by noise, by losses, or by another format.

For another format the line's bits are sampled at the receiver's own rate.  The receiver looks for the start bit (a
falling edge), samples each bit in its middle, and accepts the character regardless of parity and stop bits, as a UART
hands it over with an error flag.  Each chunk of bytes is sampled by itself.
"""

from random import Random

from fieldrig_bus.serial.message import Format


def noisy(data: bytes, bit_error_rate: float, random: Random) -> bytes:
    """Return the characters with each bit inverted by chance."""
    flips = (sum((random.random() < bit_error_rate) << place for place in range(8)) for _ in data)
    return bytes(byte ^ flip for byte, flip in zip(data, flips, strict=True))


def thinned(data: bytes, share: float, random: Random) -> bytes:
    """Return the characters without those that are lost by chance."""
    return bytes(byte for byte in data if random.random() >= share)


def garbled_by_rate(data: bytes, baud: int, received_as: Format) -> bytes:
    """Return the characters that were sent in the receiver's format but for the rate, in bit/s."""
    sent_as = Format(baud, received_as.data_bits, received_as.parity, received_as.stop_bits)
    return garbled(data, sent_as, received_as)


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
