"""The extension for Visual Studio Code and the editors that are built like it: its files, and how they get there.

The extension itself is plain JavaScript in the folder `extension`; it starts `fieldrig` for everything that it shows.
"""
