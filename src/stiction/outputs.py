"""Where results go: whether a file can be written is found out before the work, not after it."""

from __future__ import annotations

import os
from pathlib import Path

from stiction.errors import OutputError


def writable(name: str, path: str | Path) -> Path:
    """The path, if a file can be written there; its folder is made if it is missing.

    Args:
        name: what the sentence calls the parameter, such as ``--html``.

    Raises:
        OutputError: with the reason. An existing file is left untouched.
    """
    target = Path(path)
    folder = target.parent
    if target.is_dir():
        raise OutputError(f"{name} must name a file, and {str(target)!r} is a folder.")
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise OutputError(f"{name} cannot be written: folder {str(folder)!r}: {error.strerror or error}.") from None
    existed = target.exists()
    try:
        with target.open("ab"):
            pass
    except OSError as error:
        raise OutputError(f"{name} cannot be written: {str(target)!r}: {error.strerror or error}.") from None
    if not existed:
        os.unlink(target)
    return target
