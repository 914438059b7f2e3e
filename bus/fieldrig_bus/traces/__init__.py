"""Trace formats of other programs, which the entry points `fieldrig.trace_formats` name.

A format is a module of the shape of `fieldrig.traces.formats.Format`.
"""
