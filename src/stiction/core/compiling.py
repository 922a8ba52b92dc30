"""How Numba is kept from work that nobody needs: the first step of a new user waits for all of it.

Numba optimises every function together with all that it calls, and makes machine code of it, before its caller takes it
over, optimises it again, and so on up to the entry: a kernel of 300 helpers, eight deep, is optimised eight times, and
of all the machine code only the entry's is ever run. A :class:`LinkedLibrary` keeps a helper as it was lowered; an
:class:`EntryLibrary` links each of those below it once, and optimises once. Helpers need none of Numba's passes for
closures, lists, literals and expressions of arrays either, each of which goes through the whole function again.

Such a helper cannot be called from Python by itself, but then it never is: in Python it is a Python function.

And while it compiles, Numba makes millions of objects that all stay: Python's garbage collector goes through them again
and again and finds nothing, for a third of the time. It rests meanwhile; 250 MB more are in use for as long.

For each call that it meets, Numba asks a table whether that helper is known with these arguments, some hundred thousand
times; the options of the caller are part of the question, in a class of which all values have the same hash and are
then compared option by option. :class:`SharedFlags` are told apart by which they are.
"""

from __future__ import annotations

import gc
from typing import Any, ClassVar

from llvmlite.binding import Linkage
from numba.core import event, typed_passes, untyped_passes
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler, Flags
from numba.core.compiler_machinery import PassManager

NEEDLESS = {
    untyped_passes.WithLifting,
    untyped_passes.InlineClosureLikes,
    untyped_passes.MakeFunctionToJitFunction,
    untyped_passes.InlineInlinables,
    untyped_passes.FindLiterallyCalls,
    untyped_passes.LiteralUnroll,
    untyped_passes.LiteralPropagationSubPipelinePass,
    typed_passes.InlineOverloads,
    typed_passes.NopythonRewrites,
    typed_passes.DumpParforDiagnostics,
}
"""Passes over what helpers do not have."""


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

    _is_whole = False

    @property
    def codegen(self) -> Any:
        """The code generator."""
        return _NoAddresses(self._codegen)

    def get_pointer_to_function(self, name: str) -> int:
        """None."""
        self._ensure_finalized()
        return 0

    def finalize(self) -> None:
        """Nothing can be added any more."""
        self._raise_if_finalized()
        self._finalize_dynamic_globals()
        self._finalized = True

    def own_module(self) -> Any:
        """The helper without what it calls."""
        return super()._get_module_for_linking()

    def _get_module_for_linking(self) -> Any:
        """For a caller that is no entry of ours: the helper with all that it calls."""
        if not self._is_whole:
            self._is_whole, self._shared_module = True, None
            for library in below(self):
                self._final_module.link_in(_module_of(library), preserve=True)
        return super()._get_module_for_linking()

    def _optimize_functions(self, module: Any) -> None:
        module.data_layout = self._codegen._data_layout


class EntryLibrary(JITCodeLibrary):
    """Code of an entry with that of all helpers below it."""

    def finalize(self) -> None:
        """Link, optimise and make machine code."""
        for library in below(self):
            self._final_module.link_in(_module_of(library), preserve=True)
            self._reload_init.update(library._reload_init)
        self._linking_libraries = []
        for function in self._final_module.functions:
            if function.linkage == Linkage.linkonce_odr:
                # Nobody else calls it: of an array it is given the fields that it reads, and not all seven. So nobody
                # may find it by its name either, as LLVM's loader lets whoever has a function of that name do.
                function.linkage = Linkage.internal
                function.name = f"{function.name}.{self.name}"
        super().finalize()

    def _optimize_final_module(self) -> None:
        # once; Numba does it twice, to bring counts of references together, of which there are hardly any
        passes, builder = self._codegen._module_pass_manager()
        passes.run(self._final_module, builder)


class SharedFlags(Flags):
    """Options of a compilation, which have one copy with all that are equal to them."""

    __slots__ = ("_hash",)
    _hash: int
    _copies: ClassVar[dict[str, SharedFlags]] = {}

    def copy(self) -> SharedFlags:
        """The copy that stands for these options while they hold; nobody changes it."""
        words = repr(sorted(self._values.items(), key=str))
        if words not in self._copies:
            self._copies[words] = SharedFlags(self)
            self._copies[words]._hash = hash(words)
        return self._copies[words]

    def __hash__(self) -> int:
        return self._hash if hasattr(self, "_hash") else super().__hash__()

    def __eq__(self, other: object) -> bool:
        return self is other or super().__eq__(other)


def below(library: Any) -> list[Any]:
    """The libraries that a library asks for, and those that its helpers ask for, each once."""
    found: dict[int, Any] = {}
    left = list(library._linking_libraries)
    while left:
        one = left.pop()
        if id(one) not in found:
            found[id(one)] = one
            if isinstance(one, LinkedLibrary):
                left.extend(one._linking_libraries)
    return list(found.values())


def _module_of(library: Any) -> Any:
    return library.own_module() if isinstance(library, LinkedLibrary) else library._get_module_for_linking()


class LinkedCompiler(Compiler):
    """Numba's compiler without what helpers do not need, and with a :class:`LinkedLibrary` for what it makes."""

    library: type[JITCodeLibrary] = LinkedLibrary

    def __init__(
        self, typingctx: Any, targetctx: Any, library: Any, args: Any, returned: Any, flags: Flags, *others: Any
    ) -> None:
        if library is None:
            library = self.library(targetctx.codegen(), self.library.__name__)
            library.enable_object_caching()
        super().__init__(typingctx, targetctx, library, args, returned, SharedFlags(flags), *others)

    def define_pipelines(self) -> list[Any]:
        """The passes, in their order."""
        (whole,) = super().define_pipelines()
        shorter = PassManager(whole.pipeline_name)
        for each, words in whole.passes:
            if each not in NEEDLESS:
                shorter.add_pass(each, words)
        shorter.finalize()
        return [shorter]


class EntryCompiler(LinkedCompiler):
    """The same for entries."""

    library = EntryLibrary


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
