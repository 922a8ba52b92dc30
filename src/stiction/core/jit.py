"""The only place that decides how a function is compiled, and where its machine code is kept.

Numba keys its cache by the source file of the *entry* function alone: after an edit in a callee's file it would load
stale machine code and give silently wrong physics (seen with numba 0.68.1). So the entries of this package are cached
in a folder whose name is a hash of every source file of ``core``, of the versions that matter and of the CPU.

``jit``     small helpers: compiled lazily, inlined by LLVM into the entry that calls them, never cached alone; they
            count no references to arrays.
``inlined`` such a helper that is short and called often.
``entry``   the few fat kernels that Python calls: cached on disk, they release the GIL.
``part``    the same for what such a kernel calls by its address.
"""

from __future__ import annotations

import hashlib
import os
import platform
import shutil
import sys
import tempfile
import time
import warnings
from functools import cache
from pathlib import Path
from typing import Any

import llvmlite
import llvmlite.binding as llvm
import numba
import numba.extending
import numpy as np

from stiction.core.compiling import EntryCompiler, LinkedCompiler, no_collection
from stiction.core.kernel_cache import KernelCache

CORE = Path(__file__).resolve().parent
KEPT_FOLDERS = 6
KEPT_DAYS = 30.0


def cache_key(folder: Path = CORE) -> str:
    """Hash of all kernel sources below ``folder``, the versions of compiler and interpreter, and the CPU."""
    digest = hashlib.sha256()
    for source in sorted(folder.rglob("*.py")):
        digest.update(source.relative_to(folder).as_posix().encode())
        digest.update(source.read_bytes())
    versions = (sys.version, numba.__version__, llvmlite.__version__, np.__version__)
    digest.update(repr((*versions, platform.machine(), llvm.get_host_cpu_name())).encode())
    return digest.hexdigest()[:16]


def user_cache() -> Path:
    """The folder in which this system keeps a user's caches."""
    if sys.platform == "win32":
        return Path(os.environ.get("LOCALAPPDATA", Path.home() / "AppData" / "Local"))
    if sys.platform == "darwin":
        return Path.home() / "Library" / "Caches"
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")


def _prepare(folder: Path) -> bool:
    """Make the folder and mark it as used now; False where it cannot be written."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        probe = folder / f".used-{os.getpid()}"
        probe.touch()
        probe.unlink()
        os.utime(folder)
    except OSError:
        return False
    return True


def _prune(parent: Path, keep: Path) -> None:
    """Delete kernel folders of older sources: beyond the newest few, and those unused for a month."""
    try:
        folders = sorted((f for f in parent.iterdir() if f.is_dir()), key=lambda f: f.stat().st_mtime, reverse=True)
        for age, folder in enumerate(folders):
            if folder != keep and (age >= KEPT_FOLDERS or time.time() - folder.stat().st_mtime > KEPT_DAYS * 86400):
                shutil.rmtree(folder, ignore_errors=True)
    except OSError:
        return


def cache_folder() -> Path | None:
    """The folder for this very state of the sources, made and writable, or None where no cache can be kept.

    ``NUMBA_CACHE_DIR``, if the user set it, says where; the key is appended there too, so that it is never stale.
    """
    chosen = os.environ.get("NUMBA_CACHE_DIR")
    parent = Path(chosen) / "stiction" if chosen else user_cache() / "stiction"
    folder = parent / cache_key()
    if _prepare(folder):
        _prune(parent, folder)
        return folder
    fallback = Path(tempfile.gettempdir()) / f"stiction-{os.getuid() if hasattr(os, 'getuid') else 'user'}"
    if _prepare(fallback / folder.name):
        warnings.warn(f"Kernel cache {parent} cannot be written; {fallback} is used instead.", stacklevel=2)
        return fallback / folder.name
    warnings.warn(f"Kernel cache {parent} cannot be written; every process compiles its kernels anew.", stacklevel=2)
    return None


HELPER: Any = {
    "error_model": "numpy",
    "no_cpython_wrapper": True,
    "no_cfunc_wrapper": True,
    "_nrt": False,
    "pipeline_class": LinkedCompiler,
}
"""Options with which helpers are compiled, operators of types included."""

jit = numba.extending.register_jitable(**HELPER)
"""Decorator of a helper. It may neither make an array nor return one: then no references need to be counted, which
would cost two atomic operations for each array in the arguments of a call, or taken out of a tuple."""

inlined = numba.extending.register_jitable(**HELPER, forceinline=True)
"""Decorator of a helper so short that to hand over its arguments would take longer than what it does."""

ENTRY: Any = {"error_model": "numpy", "nogil": True, "pipeline_class": EntryCompiler}
"""Options with which entries are compiled."""
PART: Any = {**ENTRY, "_nrt": False}
"""The same for parts of entries, see :mod:`stiction.core.parts`: like helpers, they count no references."""

config: Any = numba.config


@cache
def kernel_folder() -> Path | None:
    """:func:`cache_folder`, found once a process."""
    return cache_folder()


def entry(function):
    """Decorator of an entry kernel: cached in :func:`cache_folder`, GIL released."""
    return _kernel(function, ENTRY)


def part(function):
    """Decorator of a part of an entry, which is cached like one."""
    return _kernel(function, PART)


def _kernel(function, options):
    if config.DISABLE_JIT:
        return function
    kernel = numba.njit(**options)(function)
    no_collection.entries.add(kernel)
    folder = kernel_folder()
    if folder is not None:
        # The cache folder is read when a cache is made, so other packages' caches stay where they are.
        before = config.CACHE_DIR
        config.CACHE_DIR = str(folder)
        try:
            kernel._cache = KernelCache(function)
        finally:
            config.CACHE_DIR = before
    return kernel


APART = "nsgs."
"""Kernels of contact problems on their own: where only these lie in the cache, a world still has to compile."""


def is_cold() -> bool:
    """Whether the cache holds no machine code yet for these sources, so that the first step has to compile."""
    if config.DISABLE_JIT:
        return False
    folder = kernel_folder()
    return folder is None or all(code.name.startswith(APART) for code in folder.rglob("*.nbc"))
