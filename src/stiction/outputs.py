"""Where results go: whether a file can be written is found out before the work, not after it."""

from __future__ import annotations

from pathlib import Path

from stiction.errors import OutputError


def writable(name: str, path: str | Path, *, make_folder: bool = False) -> Path:
    """The path, if a file can be written there. An existing file is left as it is, a new one leaves no trace.

    Args:
        name: what the sentence calls the parameter, such as ``--html``.
        path: of the file.
        make_folder: make the folder if it is missing.

    Raises:
        OutputError: with the reason.
    """
    target = Path(path)
    try:
        if make_folder:
            target.parent.mkdir(parents=True, exist_ok=True)
        existed = target.exists()
        with target.open("ab"):
            pass
        if not existed:
            target.unlink()
    except OSError as error:
        raise not_writable(name, target, error) from error
    return target


def not_writable(name: str, path: Path, error: OSError) -> OutputError:
    """What to raise when a file could not be written."""
    return OutputError(f"{name} must be a file that can be written, got {str(path)!r} ({error.strerror or error}).")
