"""Time stamps of the message logger: time since power-on as `DDD HH:MM:SS.sss`.

Source: manual 4346-4360 (digest PD-115): leading parts that are zero are omitted; before V00.07.00 a time stamp is a
plain number of milliseconds.
"""


def stamp(ms: int, *, is_plain: bool = False) -> str:
    """Return a time stamp such as `1`, `9.540`, `22:39.709`, `2:35:21.429` or `1 02:35:21.429`."""
    if is_plain:
        return str(ms)
    seconds, rest = divmod(ms, 1000)
    minutes, seconds = divmod(seconds, 60)
    hours, minutes = divmod(minutes, 60)
    days, hours = divmod(hours, 24)
    if days:
        return f"{days} {hours:02}:{minutes:02}:{seconds:02}.{rest:03}"
    if hours:
        return f"{hours}:{minutes:02}:{seconds:02}.{rest:03}"
    if minutes:
        return f"{minutes}:{seconds:02}.{rest:03}"
    return f"{seconds}.{rest:03}" if seconds else str(rest)
