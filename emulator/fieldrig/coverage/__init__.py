"""Coverage: what of a program has run, from marks in the generated code to reports."""
