"""Exceptions. All that the library says is wrong is an Error."""


class Error(Exception):
    """A run that failed. The text is one sentence; `measures` are the numbers that it is based on, by name."""

    measures: dict = {}


class InputError(Error, ValueError):
    """An argument, or a file that one names, cannot be used."""


class OutputError(Error, OSError):
    """A file cannot be written."""


class GpvcWarning(UserWarning):
    """What the library warns of."""
