"""Pipes of the PAM: generators, transformers and converters, each computed once in every period of its pipe.

Each block is a file with its formula and its states (chapter 5 of the manual).  A block takes and gives a value in each
period.  It knows the period in seconds, and has no clock of its own.
"""
