"""Pictures in characters: bodies and curves in braille dots, for the app and the command line.

Each cell has the number of an ink. The callers choose the colours of the inks.
"""
