"""What is compiled on this machine: read from the cache folder, without compiling anything."""

from __future__ import annotations

import ast
import json
import pickle
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, NamedTuple

from numba.core.event import Event, Listener, register, unregister

TIMES = "compile-times.json"
"""Beside the kernels: how long each took."""
OFF = {"none", "omitted(default=None)"}
"""Types of an argument that a variant does without."""
ON = "omitted(default=1)"
"""Type of a switch that is on (:mod:`stiction.core.parts`)."""


class Kernel(NamedTuple):
    """An entry kernel in the cache.

    Attributes:
        name: module and function.
        variants: of each compiled variant, the switches that it has on; what a world does not need is not compiled.
        size: of its machine code, bytes.
        seconds: how long all variants took to compile, None where nobody noted it.
    """

    name: str
    variants: list[list[str]]
    size: int
    seconds: float | None


def folder_size(folder: Path) -> int:
    """Bytes of all files below it."""
    return sum(file.stat().st_size for file in folder.rglob("*") if file.is_file())


def compiled(folder: Path) -> list[Kernel]:
    """The kernels in a cache folder, in alphabetical order.

    An index that this version of Numba does not understand is left out.
    """
    times = _times(folder)
    variants: dict[str, dict[Any, None]] = {}
    sizes: dict[str, int] = {}
    for index in sorted(folder.rglob("*.nbi")):
        name = index.name.split("-")[0]
        try:
            with index.open("rb") as file:
                pickle.load(file)  # the version of Numba
                _, overloads = pickle.loads(file.read())
        except (OSError, ValueError, TypeError, EOFError, pickle.UnpicklingError, AttributeError, ImportError):
            continue
        overloads = overloads.items() if isinstance(overloads, dict) else overloads
        variants.setdefault(name, {}).update(dict.fromkeys(key[0] for key, _ in overloads))
        sizes[name] = sizes.get(name, 0) + sum(code.stat().st_size for code in index.parent.glob(f"{name}-*.nbc"))
    return [
        Kernel(name, _switches(name, list(variants[name])), sizes[name], times.get(name)) for name in sorted(variants)
    ]


def _switches(name: str, signatures: list[Any]) -> list[list[str]]:
    """Of each signature, the arguments that are there and that others leave out."""
    names = _arguments(name)
    if not names or any(len(names) != len(one) for one in signatures):
        return [[] for _ in signatures]
    texts = [[str(kind) for kind in one] for one in signatures]
    optional = [k for k in range(len(names)) if any(one[k] in {*OFF, ON} for one in texts)]
    return [[names[k] for k in optional if one[k] not in OFF] for one in texts]


def _arguments(name: str) -> list[str]:
    """Names of a kernel's arguments, from its source: to import it would take longer."""
    from stiction.core.jit import CORE

    module, _, function = name.partition(".")
    for source in CORE.rglob(f"{module}.py"):
        for node in ast.parse(source.read_text(encoding="utf-8")).body:
            if isinstance(node, ast.FunctionDef) and node.name == function:
                return [argument.arg for argument in node.args.args]
    return []


def _times(folder: Path) -> dict[str, float]:
    try:
        noted = json.loads((folder / TIMES).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
    return noted if isinstance(noted, dict) else {}


@contextmanager
def noting_times(on_compile: Callable[[], None] | None = None) -> Iterator[None]:
    """Whatever kernel is compiled meanwhile, how long it took is noted beside it in the cache.

    Args:
        on_compile: told when that begins.
    """
    from stiction.core.jit import kernel_folder
    from stiction.core.side_by_side import COMPILED_ELSEWHERE

    folder = kernel_folder()
    if folder is None:
        yield
        return
    listener = _Stopwatch(on_compile)
    for kind in ("numba:compile", COMPILED_ELSEWHERE):
        register(kind, listener)
    try:
        yield
    finally:
        for kind in ("numba:compile", COMPILED_ELSEWHERE):
            unregister(kind, listener)
        if listener.seconds:
            times = _times(folder)
            for name, seconds in listener.seconds.items():
                times[name] = times.get(name, 0.0) + seconds
            with suppress(OSError):  # a note, and no reason to fail
                (folder / TIMES).write_text(json.dumps(times, indent=1), encoding="utf-8")


class _Stopwatch(Listener):
    """Hears when Numba compiles, and what a child has compiled; what is compiled inside something else belongs to
    that."""

    def __init__(self, on_compile: Callable[[], None] | None) -> None:
        self.seconds: dict[str, float] = {}
        self._begun: list[float] = []
        self._on_compile = on_compile

    def on_start(self, event: Event) -> None:
        """Told by Numba when it begins."""
        if not self._begun and self._on_compile is not None:
            self._on_compile()
        self._begun.append(time.perf_counter())

    def on_end(self, event: Event) -> None:
        """Told by Numba when it is done, or after a child has ended."""
        if "seconds" in event.data:
            self._note(event.data["module"], event.data["kernel"], event.data["seconds"])
            return
        took = time.perf_counter() - self._begun.pop()
        if not self._begun:
            function = event.data["dispatcher"].py_func
            self._note(function.__module__, function.__name__, took)

    def _note(self, module: str, kernel: str, seconds: float) -> None:
        name = f"{module.rpartition('.')[2]}.{kernel}"
        self.seconds[name] = self.seconds.get(name, 0.0) + seconds
