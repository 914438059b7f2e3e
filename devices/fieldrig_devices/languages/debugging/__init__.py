"""The debugging service: one protocol for the programs of every language in this project.

A device whose programs can be debugged gives a `Debuggee` (`debuggee.py`), and `DebugService` (`service.py`) answers
the questions of editors and command lines about it.  They arrive as `debug` questions on the control service of the
rig; `docs/programs/debugging.md` documents them.  Traces are recordings of
the kernel, which `traces.py` begins for a tool.
"""
