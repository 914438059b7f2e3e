"""Turns the checked program into resumable instructions.

names          what generated Python may use, and what it is called there
values         the text of a computed value with the range that it can have
emitter        the lines and the cost of one instruction
places         addresses, and reading and writing what is there
expressions    operators, conversions and standard functions
hoisting       calls in expressions, which are instructions of their own in front of it
statements     statements as instructions and jumps
routines       a routine for each body, and the program as a whole
"""
