"""The RS422 port: variables over a serial line (chapter 15)."""
