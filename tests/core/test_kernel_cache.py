"""Machine code on disk, and processes that write it at the same time."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from stiction.core.kernel_cache import KernelFiles

STAMP = (1.0, 2)


@pytest.fixture
def files(tmp_path: Path) -> KernelFiles:
    """A kernel's files."""
    return KernelFiles(str(tmp_path), "kernel-1.py311", STAMP)


def test_what_was_saved_is_found(files: KernelFiles) -> None:
    assert files.load("one") is None
    files.save("one", "code of one")
    files.save("two", "code of two")
    assert (files.load("one"), files.load("two"), files.load("three")) == ("code of one", "code of two", None)


def test_saved_again_it_replaces_the_old(files: KernelFiles, tmp_path: Path) -> None:
    files.save("one", "code of one")
    files.save("one", "newer code")
    assert files.load("one") == "newer code"
    assert len(list(tmp_path.glob("*.nbc"))) == 1


def test_it_holds_what_can_be_loaded(files: KernelFiles, tmp_path: Path) -> None:
    assert not files.holds("one")
    files.save("one", "code of one")
    assert files.holds("one")
    assert not files.holds("two")
    (code,) = tmp_path.glob("*.nbc")
    code.unlink()
    assert not files.holds("one")
    assert files.load("one") is None


@pytest.mark.parametrize("moment", ["_load_index", "_save_data", "_save_index"])
def test_two_processes_that_save_at_once_never_mix_up_their_code(
    files: KernelFiles, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, moment: str
) -> None:
    """Another process saves its variant right before or after each thing that this one does."""
    for after in (False, True):
        folder = tmp_path / f"{moment}-{after}"
        folder.mkdir()
        mine, others = (KernelFiles(str(folder), "kernel-1.py311", STAMP) for _ in range(2))
        does, interrupted = getattr(mine, moment), []

        def step(
            *given: Any, does: Any = does, after: bool = after, seen: list[int] = interrupted, other: Any = others
        ) -> Any:
            if after:
                result = does(*given)
            if not seen:
                seen.append(1)
                other.save("other", "code of the other")
            return result if after else does(*given)

        monkeypatch.setattr(mine, moment, step)
        mine.save("mine", "my code")
        assert interrupted
        assert mine.load("mine") in {"my code", None}
        assert others.load("other") in {"code of the other", None}
        # who finds that his code was forgotten saves it again
        for name, code in (("mine", "my code"), ("other", "code of the other")):
            if not others.holds(name):
                others.save(name, code)
        assert (others.load("mine"), others.load("other")) == ("my code", "code of the other")
