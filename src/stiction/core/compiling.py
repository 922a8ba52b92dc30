"""How Numba is kept from work that nobody needs: the first step of a new user waits for all of it.

Numba optimises every function together with all that it calls, and makes machine code of it, before its caller takes it
over, optimises it again, and so on up to the entry: a kernel of 300 helpers, eight deep, is optimised eight times, and
of all the machine code only the entry's is ever run. A :class:`LinkedLibrary` keeps a helper as it was lowered; the
entry links all of them and optimises once. The step of boxes is compiled in two thirds of the time, to the same bits.

Such a helper cannot be called from Python by itself, but then it never is: in Python it is a Python function.

And while it compiles, Numba makes millions of objects that all stay: Python's garbage collector goes through them again
and again and finds nothing, for a third of the time. It rests meanwhile; 250 MB more are in use for as long.
"""

from __future__ import annotations

import gc
from typing import Any

from numba.core import event
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler


class _NoAddresses:
    """The code generator, for a library that has no place in memory: nothing is written to where its globals are.

    They are those of the entry that links it, which finds them as it does when it is loaded from the cache.
    """

    def __init__(self, codegen: Any) -> None:
        self._codegen = codegen

    def __getattr__(self, name: str) -> Any:
        return getattr(self._codegen, name)

    def set_env(self, name: str, environment: Any) -> None:
        """Nowhere."""


class LinkedLibrary(JITCodeLibrary):
    """Code of a helper, to be linked into others: neither optimised nor made machine code."""

    @property
    def codegen(self) -> Any:
        """The code generator."""
        return _NoAddresses(self._codegen)

    def get_pointer_to_function(self, name: str) -> int:
        """None."""
        self._ensure_finalized()
        return 0

    def _optimize_functions(self, module: Any) -> None:
        module.data_layout = self._codegen._data_layout

    def _optimize_final_module(self) -> None:
        pass

    def _finalize_final_module(self) -> None:
        self._finalize_dynamic_globals()
        self._verify_declare_only_symbols()
        self._finalized = True


class LinkedCompiler(Compiler):
    """Numba's compiler, with a :class:`LinkedLibrary` for what it makes."""

    def __init__(self, typingctx: Any, targetctx: Any, library: Any, *others: Any) -> None:
        if library is None:
            library = LinkedLibrary(targetctx.codegen(), "helper")
            library.enable_object_caching()
        super().__init__(typingctx, targetctx, library, *others)


class NoCollection(event.Listener):
    """Garbage is not collected while one of our entries is compiled, and what it calls."""

    def __init__(self) -> None:
        self.entries: set[Any] = set()
        self._depth = 0
        self._collects = False

    def on_start(self, event: Any) -> None:
        """A function begins to be compiled."""
        if self._depth or event.data["dispatcher"] in self.entries:
            if self._depth == 0:
                self._collects = gc.isenabled()
                gc.disable()
            self._depth += 1

    def on_end(self, event: Any) -> None:
        """It is done, or has failed."""
        if self._depth:
            self._depth -= 1
            if self._depth == 0 and self._collects:
                gc.enable()


no_collection = NoCollection()
event.register("numba:compile", no_collection)
