"""Refusals and warnings: the lines that the command would have written."""

from __future__ import annotations

import os
import sys
import warnings
from typing import Optional

_FOLDER = os.path.dirname(os.path.abspath(__file__)) + os.sep


class InputError(ValueError):
    """What was given cannot be done as asked; the text is the line that the command would have written.

    ``file``, ``column`` and ``row`` say where, as far as the fault lies in a recording's file; the header is row 1, and of a
    ``recording.toml`` the column is the key.
    """

    def __init__(
        self,
        line: str,
        file: Optional[str] = None,
        column: Optional[str] = None,
        row: Optional[int] = None,
    ) -> None:
        super().__init__(line, file, column, row)
        self.file = file
        self.column = column
        self.row = row

    def __str__(self) -> str:
        return str(self.args[0])


class ProgramError(RuntimeError):
    """An error of the program, not of its input; please report the text."""


class RecordingWarning(UserWarning):
    """What the command would have written as a warning."""


def warn(line: str) -> None:
    """Warns of ``line`` at the place outside this package that called into it."""
    frame, level = sys._getframe(1), 2
    while frame.f_back is not None and frame.f_code.co_filename.startswith(_FOLDER):
        frame, level = frame.f_back, level + 1
    warnings.warn(line, RecordingWarning, stacklevel=level)
