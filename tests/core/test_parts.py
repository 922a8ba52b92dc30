"""Parts of kernels: called by their addresses, compiled and cached by themselves."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numba
import numpy as np
import pytest
from numba.core import types

from stiction.core import jit, soft_entry, soft_parts
from stiction.core.parts import Crew, Number, Switch, Table, Variant, address_of, caller, signature
from stiction.core.team import WORKERS, make_team

ALONE = Variant(double=False, team=False)


def weigh(book: Table, row: int, factor: float, one: Number, team: Crew, squared: Switch) -> int:
    """A sum of a row, in part squared, and of what the team has to say."""
    if factor < 0.0:
        raise ValueError("factor must not be negative")
    total = 0
    for k in range(book.shape[1]):
        total += book[row, k] * book[row, k] if squared is not None else book[row, k]
    if team is not None:
        total += 1000 * team.words[WORKERS]
    return int(total * factor * one)


@pytest.fixture
def part(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Any:
    """A part with a cache of its own."""
    monkeypatch.setattr(jit, "kernel_folder", lambda: tmp_path)
    return jit.part(weigh)


def entry_calling(part: Any) -> Any:
    """An entry that hands over what it gets."""
    call = caller(part)

    @jit.entry
    def outer(address, book, factor, one, team):
        return call(address, (book, 1, factor, one, team)) + 1

    return outer


BOOK = np.array([[9, 9, 9], [1, 2, 3]])
ONE = np.float32(1.0)
compiled = pytest.mark.skipif(jit.config.DISABLE_JIT, reason="nothing is compiled")


@compiled
def test_one_entry_calls_every_variant_of_a_part(part: Any) -> None:
    outer = entry_calling(part)
    plain, squared = (address_of(part, ALONE._replace(on=on)) for on in ((), ("squared",)))
    assert plain != squared
    assert outer(plain, BOOK, 2.0, ONE, None) == 2 * 6 + 1
    assert outer(squared, BOOK, 2.0, ONE, None) == 2 * 14 + 1
    assert len(outer.overloads) == 1
    assert len(part.overloads) == 2


@compiled
def test_precision_and_team_are_arguments_of_the_machine_code(part: Any) -> None:
    outer = entry_calling(part)
    address = address_of(part, Variant(double=True, team=True))
    assert outer(address, BOOK, 1.0, 1.0, make_team(3)) == 6 + 3000 + 1


@compiled
def test_an_exception_in_a_part_comes_out_of_the_entry(part: Any) -> None:
    outer = entry_calling(part)
    with pytest.raises(ValueError, match="factor must not be negative"):
        outer(address_of(part, ALONE), BOOK, -1.0, ONE, None)


@compiled
def test_a_part_can_be_called_from_python_too(part: Any) -> None:
    assert part(BOOK, 1, 2.0, ONE, None, None) == weigh(BOOK, 1, 2.0, ONE, None, None) == 12


@compiled
@pytest.mark.parametrize(
    ("given", "complaint"),
    [
        ((BOOK, 1, 2.0, ONE), r"5 arguments are wanted, not 4: book, row, factor, one, team"),
        ((BOOK, 1, 2, ONE, None), r"factor must be float, not int64"),
        ((BOOK, 1.0, 2.0, ONE, None), r"row must be int, not float64"),
        ((BOOK * 1.0, 1, 2.0, ONE, None), r"book must be Table, not array\(float64, 2d, C\)"),
        ((BOOK, 1, 2.0, 1, None), r"one must be Number, not int64"),
        ((BOOK, 1, 2.0, ONE, 7), r"team must be Crew, not int64"),
    ],
)
def test_arguments_that_a_part_was_not_declared_with_are_refused(part: Any, given: Any, complaint: str) -> None:
    call = caller(part)

    @numba.njit
    def outer(address, arguments):
        return call(address, arguments)

    with pytest.raises(numba.TypingError, match=complaint):
        outer(address_of(part, ALONE), given)


@compiled
def test_a_part_must_return_an_int(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(jit, "kernel_folder", lambda: tmp_path)

    @jit.part
    def half(x: float) -> int:
        return x / 2.0

    with pytest.raises(TypeError, match="half must return an int, not float64"):
        address_of(half, ALONE)


@compiled
def test_variants_are_cached(part: Any) -> None:
    address_of(part, ALONE)
    again = jit.part(weigh)
    assert entry_calling(again)(address_of(again, ALONE), BOOK, 1.0, ONE, None) == 7
    assert again.stats.cache_hits[signature(again, ALONE)] == 1
    assert not again.stats.cache_misses


def test_in_plain_python_the_address_is_the_function(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(jit.config, "DISABLE_JIT", 1)
    part = jit.part(weigh)
    call = caller(part)
    assert call(address_of(part, ALONE), (BOOK, 1, 1.0, 1.0, None)) == 6
    assert call(address_of(part, ALONE._replace(on=("squared",))), (BOOK, 1, 1.0, 1.0, None)) == 14


@compiled
def test_a_part_has_no_more_variants_than_its_own_switches_make() -> None:
    """What a scene adds to another one compiles the part that knows of it, and no other."""

    def kinds(*on: str) -> dict[str, Any]:
        kernels = (
            soft_entry.soft_step, soft_parts.pairs, soft_parts.find, soft_parts.solve, soft_parts.finish,
            soft_parts.impacts,
        )  # fmt: skip
        return {kernel.py_func.__name__: signature(kernel, ALONE._replace(on=on)) for kernel in kernels}

    def changed(*on: str) -> set[str]:
        return {name for name, types_of in kinds(*on).items() if types_of != kinds()[name]}

    assert changed("boxes_meet") == changed("hulls") == changed("boxes_meet", "hulls") == {"find"}
    assert changed("rolls") == changed("laws") == changed("exact") == {"solve"}
    assert changed("bounces") == set()
    assert signature(soft_parts.pairs, ALONE)[1:] == (types.int64, types.int64, types.float64)
