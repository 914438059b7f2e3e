"""Formats of traces for other programs, found by the entry points `fieldrig.trace_formats`.

A format is a module with `write(entries, file, start_unix_ns) -> int`, the number of entries written (those of
families that it has no place for are skipped), and `read(file) -> Iterator[TraceEntry]`.
"""
