"""Trace formats of other programs, which the entry points `fieldrig.trace_formats` name.

A format is a module with `write(entries, file, start_unix_ns) -> int`, which returns the number of entries written
(entries of families that the format can't represent are skipped), and `read(file) -> Iterator[TraceEntry]`.
"""
