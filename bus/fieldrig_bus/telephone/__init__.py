"""The telephone network: lines with numbers, calls between them, and the carriers of modems."""
