"""The PAM's real-time language: tokens, preprocessor, parser, checker and printer (chapters 1 to 6 of the manual)."""
