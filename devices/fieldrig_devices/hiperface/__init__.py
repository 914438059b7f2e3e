"""HIPERFACE: the SinCos encoder of an SM motor with its name plate, and the drive's end of the line."""
