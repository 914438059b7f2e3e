"""Trace formats of other programs, which the entry points `fieldrig.trace_formats` name.

A format is a module of the shape of `fieldrig.traces.formats.Format`.

CAN logs are read and written here, and python-can's readers and writers are the judge of their tests.  With its reader
in their place, reading a log takes from 1.6 to 3 times as long, and with its writer from 1.7 to 3.2 times (SQLite: the
same, but most rows are lost), which would make each conversion slower than python-can's own converter
(docs/developers/benchmarks.md, "Readers and writers of CAN logs").  Each module says what else it could not keep.
"""
