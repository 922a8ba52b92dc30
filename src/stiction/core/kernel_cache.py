"""A kernel's machine code on disk: Numba's cache, for processes that compile at the same time.

Numba numbers the files of a kernel's variants. Two processes that save different variants at once can choose the same
number, and then the index names the code of one as that of the other. Here each file has a name of its own, and is
there before the index names it. The worst that two can do to each other is that one variant is compiled again.
"""

from __future__ import annotations

import uuid
from pathlib import Path
from typing import Any

from numba.core.caching import FunctionCache, IndexDataCacheFile


class KernelFiles(IndexDataCacheFile):
    """The index of a kernel's variants, and a file for each."""

    def save(self, key: Any, data: Any) -> None:
        """Save a variant, then the index as it is by now, with it."""
        name = self._load_index().get(key) or self._data_name_pattern.format(number=uuid.uuid4().int)
        self._save_data(name, data)
        self._save_index(self._load_index() | {key: name})

    def holds(self, key: Any) -> bool:
        """Whether a variant is there."""
        name = self._load_index().get(key)
        return name is not None and Path(self._data_path(name)).is_file()


class KernelCache(FunctionCache):
    """The cache of one kernel, in the folder that Numba's configuration names now."""

    def __init__(self, function: Any) -> None:
        super().__init__(function)
        stamp = self._impl.locator.get_source_stamp()
        self._cache_file = self._files = KernelFiles(self._cache_path, self._impl.filename_base, stamp)

    def holds(self, signature: tuple[Any, ...], context: Any) -> bool:
        """Whether the variant for arguments of these types is there."""
        with self._guard_against_spurious_io_errors():
            return self._files.holds(self._index_key(signature, context.codegen()))
        return False
