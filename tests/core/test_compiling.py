"""How helpers are compiled: into the kernels that call them, once, while the garbage collector rests."""

from __future__ import annotations

import gc
import math
from pathlib import Path
from typing import Any

import numba
import numpy as np
import pytest
from numba.core import event
from numba.core.compiler import Flags

from stiction.core import jit, state
from stiction.core.collide.narrow import find_contacts
from stiction.core.compiling import LinkedLibrary, SharedFlags, no_collection
from stiction.core.jit import ENTRY

pytestmark = pytest.mark.skipif(jit.config.DISABLE_JIT, reason="nothing is compiled")


@jit.jit
def double(x):
    """A helper of a helper."""
    return x + x


@jit.jit
def fourfold(x):
    """A helper."""
    return double(double(x))


@jit.jit
def refuse(x):
    """A helper that raises."""
    if x < 0.0:
        raise ValueError("x must not be negative")
    return x


@pytest.fixture
def kernel(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Any:
    """An entry that was never compiled before."""
    monkeypatch.setattr(jit, "kernel_folder", lambda: tmp_path)

    @jit.entry
    def kernel(numbers):
        total = 0.0
        for k in range(len(numbers)):
            total += fourfold(refuse(numbers[k]))
        return total

    return kernel


class Watch(event.Listener):
    """Whether garbage was collected while functions were compiled."""

    def __init__(self) -> None:
        self.collects: list[bool] = []

    def on_start(self, event: Any) -> None:
        """A function begins to be compiled."""

    def on_end(self, event: Any) -> None:
        """It is done."""
        self.collects.append(gc.isenabled())


def compiled_under_watch(kernel: Any, *given: Any) -> list[bool]:
    """Call a kernel for the first time."""
    watch = Watch()
    with event.install_listener("numba:run_pass", watch):
        kernel(*given)
    return watch.collects


def test_helpers_are_linked_into_the_entry_and_give_what_they_do_in_python(
    kernel: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    ends, linked = LinkedLibrary.finalize, []

    def note(library: LinkedLibrary) -> None:
        ends(library)
        linked.append({function.name for function in library.get_defined_functions()})

    monkeypatch.setattr(LinkedLibrary, "finalize", note)
    numbers = np.array([1.0, 2.5, 4.0])
    assert kernel(numbers) == kernel.py_func(numbers) == 30.0
    assert [len(names) for names in linked] == [1, 1, 1]  # refuse, double and fourfold, each without what it calls
    (overload,) = kernel.overloads.values()
    assert not isinstance(overload.library, LinkedLibrary)
    is_defined = overload.library._codegen._engine.is_symbol_defined
    assert not any(is_defined(name) for names in linked for name in names)


def test_kernels_of_others_may_call_helpers() -> None:
    assert numba.njit(lambda x: fourfold(x) + double(x))(2.0) == 12.0


def test_kernels_of_others_do_not_meet_the_helpers_of_an_entry() -> None:
    """These are called otherwise; LLVM's loader would let whoever comes later have them by their names."""
    bodies, kinds = state.make_bodies(2)
    kinds[:, state.SHAPE], kinds[0, state.MOBILITY] = state.BOX, state.DYNAMIC
    bodies[:, state.SIZE : state.SIZE + 3] = 0.5
    bodies[:, state.ORIENTATION] = bodies[0, state.INVERSE_MASS] = 1.0
    found = []
    for options in (ENTRY, {"error_model": "numpy"}):
        kernel = numba.njit(**options)(find_contacts)
        for k in range(20):
            bodies[1, state.POSITION : state.POSITION + 3] = 0.1 * math.sin(k), 0.3 * math.cos(k), 0.9 + 0.01 * k
            contacts, tags = state.make_contacts(8)
            pairs, scratch = np.array([[0, 1]]), state.make_lists(2, 8, 1).points
            count = kernel(bodies, kinds, pairs, 1, contacts, tags, 0.1, 1.0, scratch, 1, None)
            found.append((count, contacts[:count].tolist(), tags[:count].tolist()))
    assert found[:20] == found[20:]
    assert {count for count, _, _ in found} >= {4}


def test_an_exception_in_a_helper_comes_out_of_the_entry(kernel: Any) -> None:
    with pytest.raises(ValueError, match="x must not be negative"):
        kernel(np.array([1.0, -1.0]))


def test_the_collector_rests_while_an_entry_is_compiled_and_works_again_after(kernel: Any) -> None:
    assert gc.isenabled()
    during = compiled_under_watch(kernel, np.zeros(2))
    assert during and not any(during)
    assert gc.isenabled()


def test_who_has_turned_it_off_finds_it_off(kernel: Any) -> None:
    gc.disable()
    try:
        kernel(np.zeros(2))
        assert not gc.isenabled()
    finally:
        gc.enable()


def test_it_works_again_after_a_failure(kernel: Any) -> None:
    with pytest.raises(numba.TypingError):
        kernel("no numbers")
    assert gc.isenabled()
    assert no_collection._depth == 0


def test_kernels_of_others_are_left_alone() -> None:
    during = compiled_under_watch(numba.njit(lambda x: x + 1), 3)
    assert during and all(during)


def test_equal_options_of_compilations_share_one_copy() -> None:
    """A helper is found again among those compiled for the options of its caller, and only for those."""
    plain = Flags()
    plain.error_model = "numpy"
    quick = Flags(plain)
    quick.release_gil = True
    copies = [SharedFlags(flags).copy() for flags in (plain, Flags(plain), quick)]
    assert copies[0] is copies[1] == plain
    assert copies[0] != copies[2] == quick
    assert {copies[0]: "plain", copies[2]: "quick"} == {copies[1]: "plain", copies[2].copy(): "quick"}
