"""Layouts of other systems as their formats define them, read without Regatta.

Each module has a function that returns the edges of a file. None of them shares code with Regatta's readers.
"""
