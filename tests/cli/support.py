"""Commands called in this process, as a user gives them."""

from __future__ import annotations

import sys

import pytest

from stiction.cli import main as cli


def call(monkeypatch: pytest.MonkeyPatch, *arguments: str) -> int:
    """Exit status of ``stiction ARGUMENTS``."""
    monkeypatch.setattr(sys, "argv", ["stiction", *arguments])
    # the command shows warnings in its own way; put back afterwards what it sets for that
    monkeypatch.setattr("warnings.showwarning", lambda *_, **__: None)
    monkeypatch.setattr("warnings.simplefilter", lambda *_, **__: None)
    try:
        cli.main()
    except SystemExit as end:
        return int(end.code or 0)
    return 0
