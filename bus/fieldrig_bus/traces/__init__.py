"""Trace formats of other programs, which the entry points `fieldrig.trace_formats` name.

A format is a module with `SUFFIX`, with `FAMILIES`, which names the families of buses that it can hold or is empty if
it can hold all, with `write(entries, file, start_unix_ns) -> int`, which returns the number of entries written (entries
that the format cannot represent are skipped), and with `read(file) -> Iterator[TraceEntry]`.
"""
