"""Pictures made of characters: bodies and curves in braille dots, for the app and the command line.

NumPy alone: which colours the inks have is a matter of who shows them.
"""
