"""The kernel cache: never stale after an edit in any file of core, never in the way where it cannot be written."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import time
import warnings
from pathlib import Path
from typing import Any

import numba
import numpy as np
import pytest

import stiction
from stiction.core import jit

PACKAGE = Path(stiction.__file__).parent

PROGRAM = """
import numpy as np
from stiction.core import state, step
bodies, kinds = state.make_bodies(1)
bodies[0, state.MASS] = bodies[0, state.INVERSE_MASS] = 1.0
bodies[0, state.V] = 2.0
print(step.energy(bodies, 1, 0.0, 0.0, -9.81)[0])
"""
"""Kinetic energy of 1 kg at 2 m/s, by an entry kernel whose formula is in another file."""


def energy_by(folder: Path, cache: Path) -> float:
    """The result of PROGRAM in a new process, with the copy of the package in ``folder``."""
    environment = {k: v for k, v in os.environ.items() if not k.startswith(("NUMBA_", "PYTHON"))}
    environment |= {"PYTHONPATH": str(folder), "NUMBA_CACHE_DIR": str(cache)}
    result = subprocess.run(
        [sys.executable, "-W", "error", "-c", PROGRAM],
        env=environment, cwd=folder, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert result.returncode == 0, result.stderr
    return float(result.stdout)


def machine_code(cache: Path) -> dict[str, int]:
    """Files of machine code below a cache, by folder of the key, and when each was last written."""
    return {str(path.relative_to(cache)): path.stat().st_mtime_ns for path in cache.rglob("*.nbc")}


def test_an_edit_in_a_callees_file_is_seen(tmp_path: Path) -> None:
    """Numba alone would load what it compiled before the edit; the key in the folder's name prevents that."""
    shutil.copytree(PACKAGE, tmp_path / "stiction", ignore=shutil.ignore_patterns("__pycache__"))
    cache = tmp_path / "cache"
    assert energy_by(tmp_path, cache) == 2.0
    first = machine_code(cache)
    assert len(first) == 1

    callee = tmp_path / "stiction" / "core" / "vec.py"
    text = callee.read_text(encoding="utf-8")
    formula = "return a.x * b.x + a.y * b.y + a.z * b.z"
    assert text.count(formula) == 1
    callee.write_text(text.replace(formula, "return 2.0 * (a.x * b.x + a.y * b.y + a.z * b.z)"), encoding="utf-8")
    assert energy_by(tmp_path, cache) == 4.0
    both = machine_code(cache)
    assert len(both) == 2
    assert first.items() < both.items()
    assert len({Path(name).parts[1] for name in both}) == 2

    # the same sources again: nothing is compiled
    assert energy_by(tmp_path, cache) == 4.0
    assert machine_code(cache) == both


def test_the_key_changes_with_every_source_file_and_nothing_else(tmp_path: Path) -> None:
    core = tmp_path / "core"
    shutil.copytree(jit.CORE, core, ignore=shutil.ignore_patterns("__pycache__"))
    before = jit.cache_key(core)
    assert before == jit.cache_key()  # not a matter of where it lies
    (core / "__pycache__").mkdir()
    (core / "__pycache__" / "vec.pyc").write_bytes(b"x")
    (core / "notes.txt").write_text("x")
    assert jit.cache_key(core) == before

    seen = {before}
    for source in sorted(core.rglob("*.py")):
        with source.open("a", encoding="utf-8") as file:
            file.write("# edited\n")
        seen.add(jit.cache_key(core))
    assert len(seen) == 1 + len(list(core.rglob("*.py")))
    (core / "vec.py").rename(core / "vectors.py")
    assert jit.cache_key(core) not in seen


def test_the_key_depends_on_compiler_and_machine(monkeypatch: pytest.MonkeyPatch) -> None:
    keys = {jit.cache_key()}
    monkeypatch.setattr(numba, "__version__", "0.0")
    keys.add(jit.cache_key())
    monkeypatch.setattr("llvmlite.binding.get_host_cpu_name", lambda: "abacus")
    keys.add(jit.cache_key())
    monkeypatch.setattr(np, "__version__", "0.0")
    keys.add(jit.cache_key())
    assert len(keys) == 4


# --- where it lies ----------------------------------------------------------------------------------------------------


def test_the_user_says_where_and_the_key_is_appended(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "mine"))
    folder = jit.cache_folder()
    assert folder == tmp_path / "mine" / "stiction" / jit.cache_key()
    assert folder.is_dir()
    assert list(folder.iterdir()) == []


@pytest.mark.skipif(sys.platform in {"win32", "darwin"}, reason="XDG folders are a habit of Linux and its kin")
def test_by_default_it_lies_in_the_users_cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("NUMBA_CACHE_DIR", raising=False)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    assert jit.cache_folder() == tmp_path / "stiction" / jit.cache_key()
    monkeypatch.setenv("XDG_CACHE_HOME", "")
    assert jit.user_cache() == Path.home() / ".cache"


@pytest.mark.parametrize(
    ("platform", "variable", "wanted"),
    [
        ("win32", "LOCALAPPDATA", lambda tmp, home: tmp),
        ("darwin", None, lambda tmp, home: home / "Library" / "Caches"),
    ],
)
def test_other_systems_have_other_folders(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, platform: str, variable: str | None, wanted: Any
) -> None:
    monkeypatch.setattr(sys, "platform", platform)
    if variable:
        monkeypatch.setenv(variable, str(tmp_path))
    assert jit.user_cache() == wanted(tmp_path, Path.home())


# --- where it cannot be written ---------------------------------------------------------------------------------------


def cannot_write(*below: Path) -> Any:
    """A stand-in for ``_prepare`` that refuses these folders: as root every folder can be written."""
    prepare = jit._prepare

    def refuse(folder: Path) -> bool:
        return False if any(folder.is_relative_to(b) for b in below) else prepare(folder)

    return refuse


@pytest.fixture
def read_only_home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A cache that cannot be written, and a temporary folder of the test's own."""
    home = tmp_path / "home"
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(home))
    monkeypatch.setattr("tempfile.gettempdir", lambda: str(tmp_path / "temporary"))
    monkeypatch.setattr(jit, "_prepare", cannot_write(home))
    return home


def test_a_read_only_cache_falls_back_to_the_temporary_folder_with_a_warning(
    tmp_path: Path, read_only_home: Path
) -> None:
    with pytest.warns(UserWarning, match=r"^Kernel cache .*home.* cannot be written; .*temporary.* is used instead\.$"):
        folder = jit.cache_folder()
    assert folder is not None
    assert folder.is_relative_to(tmp_path / "temporary")
    assert folder.name == jit.cache_key()
    assert folder.is_dir()
    assert not read_only_home.exists()


def test_without_any_folder_kernels_are_compiled_and_not_cached(
    tmp_path: Path, read_only_home: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(jit, "_prepare", lambda folder: False)
    with pytest.warns(UserWarning, match=r"cannot be written; every process compiles its kernels anew\.$"):
        assert jit.cache_folder() is None

    monkeypatch.setattr(jit, "kernel_folder", lambda: None)
    assert jit.is_cold()
    kernel = jit.entry(lambda x: x + 1.0)
    assert kernel(1.0) == 2.0
    assert kernel.stats.cache_path is None
    assert not list(tmp_path.rglob("*.nbc"))


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() == 0, reason="root can write into a read-only folder")
def test_a_folder_that_really_is_read_only_is_noticed(tmp_path: Path) -> None:
    tmp_path.chmod(0o500)
    assert not jit._prepare(tmp_path / "stiction" / "key")


def test_a_file_in_the_way_is_noticed(tmp_path: Path) -> None:
    """The same for root: a folder cannot be made where a file lies."""
    (tmp_path / "stiction").write_text("not a folder")
    assert not jit._prepare(tmp_path / "stiction" / "key")


# --- what is kept -----------------------------------------------------------------------------------------------------


def old_folders(parent: Path, ages_in_days: list[float]) -> list[Path]:
    """Kernel folders that were last used so long ago, each with a file in it."""
    folders = []
    for number, age in enumerate(ages_in_days):
        folder = parent / f"key{number}"
        folder.mkdir(parents=True)
        (folder / "kernel.nbc").write_bytes(b"code")
        used = time.time() - age * 86400
        os.utime(folder, (used, used))
        folders.append(folder)
    return folders


def test_only_the_newest_few_folders_are_kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    folders = old_folders(tmp_path / "stiction", [float(age) for age in range(1, 11)])
    (tmp_path / "stiction" / "a file").write_text("left alone")
    now = jit.cache_folder()
    assert now is not None
    kept = {path for path in (tmp_path / "stiction").iterdir() if path.is_dir()}
    assert kept == {now, *folders[: jit.KEPT_FOLDERS - 1]}
    assert (tmp_path / "stiction" / "a file").exists()


def test_folders_that_nobody_used_for_a_month_go(tmp_path: Path) -> None:
    young, old, mine = old_folders(tmp_path, [jit.KEPT_DAYS - 1, jit.KEPT_DAYS + 1, 10 * jit.KEPT_DAYS])
    jit._prune(tmp_path, mine)
    assert young.exists()
    assert not old.exists()
    assert (mine / "kernel.nbc").exists()


def test_pruning_what_is_not_there_is_no_error(tmp_path: Path) -> None:
    jit._prune(tmp_path / "nowhere", tmp_path / "nowhere" / "key")


def test_the_folder_in_use_is_marked_as_used(tmp_path: Path) -> None:
    (folder,) = old_folders(tmp_path, [20.0])
    assert jit._prepare(folder)
    assert time.time() - folder.stat().st_mtime < 3600


# --- entries ----------------------------------------------------------------------------------------------------------


def test_an_entry_is_cached_in_the_folder_and_other_packages_caches_stay(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    before = jit.config.CACHE_DIR
    monkeypatch.setattr(jit, "kernel_folder", lambda: tmp_path)
    assert jit.is_cold()
    kernel = jit.entry(an_entry)
    assert before == jit.config.CACHE_DIR
    assert kernel(2.0) == 4.0
    assert len(list(tmp_path.rglob("*.nbc"))) == 1
    assert not jit.is_cold()


def test_kernels_of_contact_problems_do_not_make_a_world_warm(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(jit, "kernel_folder", lambda: tmp_path)
    (tmp_path / "nsgs.sweep-72.py311.1.nbc").write_bytes(b"code")
    assert jit.is_cold()
    (tmp_path / "step.step-31.py311.1.nbc").write_bytes(b"code")
    assert not jit.is_cold()


def an_entry(x: float) -> float:
    """Twice x."""
    return 2.0 * x


def test_no_jit_means_plain_python(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(jit.config, "DISABLE_JIT", 1)
    assert jit.entry(an_entry) is an_entry
    assert not jit.is_cold()


def test_a_helper_stays_a_plain_function() -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert jit.jit(an_entry) is an_entry
        assert numba.njit(lambda x: an_entry(x) + 1.0)(2.0) == 5.0
