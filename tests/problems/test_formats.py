"""Files in both formats: what is written comes back, what others write is read, and what is wrong is said."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from scipy.sparse import coo_array, csc_array, csr_array

from stiction.errors import InvalidInputError, NotYetError, OutputError, StictionError
from stiction.problems import ContactProblem

from .support import random_problem


def assert_same(a: ContactProblem, b: ContactProblem) -> None:
    np.testing.assert_array_equal(a.W.dense(), b.W.dense())
    np.testing.assert_array_equal(a.q, b.q)
    np.testing.assert_array_equal(a.mu, b.mu)


@pytest.mark.parametrize("name", ["a.hdf5", "a.h5", "a.dat", "a.hdf5.dat", "a.txt"])
def test_what_is_written_comes_back_to_the_bit(name: str, tmp_path: Path, rng: np.random.Generator) -> None:
    problem = random_problem(rng)
    problem.write(tmp_path / name, form="local")
    assert_same(ContactProblem.read(tmp_path / name), problem)


def test_a_global_problem_comes_back_with_its_bodies(tmp_path: Path, rng: np.random.Generator) -> None:
    problem = random_problem(rng)
    problem.write(tmp_path / "a.hdf5")
    back = ContactProblem.read(tmp_path / "a.hdf5")
    assert_same(back, problem)
    assert problem.global_form is not None and back.global_form is not None
    for name in ("M", "H"):
        old, new = getattr(problem.global_form, name), getattr(back.global_form, name)
        np.testing.assert_array_equal(old.toarray(), new.toarray())
    for name in ("f", "w"):
        np.testing.assert_array_equal(getattr(problem.global_form, name), getattr(back.global_form, name))


def test_title_and_description_are_kept(tmp_path: Path) -> None:
    problem = ContactProblem(np.eye(3), [-1.0, 0, 0], 0.3, title="one crate", description="h = 1/60 s\nμ = 0.3")
    problem.write(tmp_path / "a.hdf5")
    back = ContactProblem.read(tmp_path / "a.hdf5")
    assert (back.title, back.description) == (problem.title, problem.description)


def test_the_format_is_told_by_what_is_in_the_file_not_by_its_name(tmp_path: Path, rng: np.random.Generator) -> None:
    problem = random_problem(rng)
    problem.write(tmp_path / "a.hdf5", form="local")
    problem.write(tmp_path / "b.dat")
    (tmp_path / "a.hdf5").rename(tmp_path / "a.dat")
    (tmp_path / "b.dat").rename(tmp_path / "b.hdf5")
    for name in ("a.dat", "b.hdf5"):
        assert_same(ContactProblem.read(tmp_path / name), problem)


@pytest.mark.parametrize(("nz", "make"), [(-1, csc_array), (-2, csr_array), (None, coo_array)])
def test_all_three_storages_of_fclib_are_read(
    nz: int | None, make: Any, tmp_path: Path, rng: np.random.Generator
) -> None:
    """W need not be symmetric here, so that rows and columns cannot be mistaken for each other."""
    W = np.where(rng.random((9, 9)) < 0.6, rng.normal(size=(9, 9)), 0.0)
    matrix = make(W)
    q, mu = rng.normal(size=9), rng.random(3)
    if nz is None:  # triplets, with room to spare behind them
        i, j = matrix.coords
        i, p, x = (np.concatenate((part, np.zeros(4))) for part in (i, j, matrix.data))
        nz = matrix.nnz
    else:
        i, p, x = matrix.indices, matrix.indptr, matrix.data
    write_local(tmp_path / "a.hdf5", nz=nz, p=p, i=i, x=x, q=q, mu=mu)
    assert_same(ContactProblem.read(tmp_path / "a.hdf5"), ContactProblem(W, q, mu))


def write_local(path: Path, **given: Any) -> None:
    """A file as fclib_write_local leaves it, n contacts with W = 1 unless other arrays are given."""
    size = 3 * len(given["mu"]) if "mu" in given else 3
    unit = csr_array(np.eye(size))
    values: dict[str, Any] = {
        "spacedim": [3], "W/m": [size], "W/n": [size], "W/nzmax": [unit.nnz], "W/nz": [-2],
        "W/p": unit.indptr, "W/i": unit.indices, "W/x": unit.data,
        "vectors/q": -np.ones(size), "vectors/mu": np.full(size // 3, 0.5),
    }  # fmt: skip
    places = {"nz": "W/nz", "p": "W/p", "i": "W/i", "x": "W/x", "q": "vectors/q", "mu": "vectors/mu"}
    values |= {places.get(key, key): value for key, value in given.items()}
    whole = {"spacedim", "W/m", "W/n", "W/nzmax", "W/nz", "W/p", "W/i"}
    with h5py.File(path, "w") as file:
        for key, value in values.items():
            if value is not None:
                file[f"fclib_local/{key}"] = np.atleast_1d(np.asarray(value, np.int32 if key in whole else np.float64))


def test_the_form_of_bodies_becomes_that_of_contacts(tmp_path: Path) -> None:
    """A ball of 2 kg, 0.5 kg m^2, that falls onto the ground: W and q by hand; triplets as Siconos writes them."""
    M = np.diag([2.0, 2, 2, 0.5, 0.5, 0.5])
    H = np.zeros((6, 3))
    H[2, 0] = H[0, 1] = H[1, 2] = 1.0  # normal z, tangents x and y
    H[4, 1], H[3, 2] = -0.1, 0.1  # arm (0, 0, -0.1)
    f, w = np.array([0.2, 0, -4.0, 0, 0, 0]), np.array([0.0, 0.3, 0])
    with h5py.File(tmp_path / "a.hdf5", "w") as file:
        group = file.create_group("fclib_global")
        group["spacedim"] = np.array([3], np.int32)
        for name, dense in (("M", M), ("H", H)):
            coo = coo_array(dense)
            i, p = coo.coords
            numbers = {"m": dense.shape[0], "n": dense.shape[1], "nz": coo.nnz, "nzmax": 99}
            for key, number in numbers.items():
                group[f"{name}/{key}"] = np.array([number], np.int32)
            group[f"{name}/i"], group[f"{name}/p"], group[f"{name}/x"] = i, p, coo.data
        group["vectors/f"], group["vectors/w"], group["vectors/mu"] = f, w, np.array([0.4])
    problem = ContactProblem.read(tmp_path / "a.hdf5")
    np.testing.assert_allclose(problem.W.dense(), np.diag([0.5, 0.5 + 0.02, 0.5 + 0.02]), atol=1e-15)
    np.testing.assert_allclose(problem.q, [-2.0, 0.1 + 0.3, 0.0], atol=1e-15)


DENSE = "3\n1\n0\n3\n3\n3\t3\n 2 7 0\n 0 1 0\n 0 0 1\n -1 1 3\n 0.25\n"
BLOCKS = "3 1 1 3 3 1 1 1 3 3 2 1 0 1 0 0  2 7 0 0 1 0 0 0 1  -1 1 3 0.25 0"


@pytest.mark.parametrize("text", [DENSE, BLOCKS], ids=["dense", "blocks"])
def test_siconos_text_is_read_by_columns(text: str, tmp_path: Path) -> None:
    (tmp_path / "a.dat").write_text(text)
    problem = ContactProblem.read(tmp_path / "a.dat")
    np.testing.assert_array_equal(problem.W.dense(), [[2, 0, 0], [7, 1, 0], [0, 0, 1]])
    np.testing.assert_array_equal(problem.q, [-1, 1, 3])
    assert problem.mu.tolist() == [0.25] and problem.title == "a"


BAD_TEXTS = [
    ("", "cut short: dimension, contacts, storage, rows and columns must be 5 numbers, 0 are left"),
    ("hello", "neither FCLIB's HDF5 nor Siconos' text"),
    (DENSE[:40], "cut short: q must be 3 numbers"),
    (DENSE[:-6], "cut short: mu must be 1 numbers, 0 are left"),
    (DENSE.replace("3\n1\n0", "2\n1\n0", 1), "the dimension must be 3, got 2"),
    (DENSE.replace("3\n1\n0", "3\n2\n0", 1), "2 contacts with a matrix of 3 x 3"),
    (DENSE.replace("3\n1\n0", "3\n1\n2", 1), "the storage of the matrix must be 0 (dense) or 1 (blocks), got 2"),
    (DENSE.replace("3\n1\n0", "3\n1.5\n0", 1), "must be whole numbers up to 10000000, got 1.5"),
    (DENSE.replace("3\t3", "3\t4"), "the dense matrix is not 3 x 3"),
    (DENSE.replace("0.25", "-0.25"), "mu must be 0 or more, got -0.25 at contact 0"),
    (DENSE.replace(" 2 7", " nan 7"), "W must be finite, got nan"),
    (DENSE.replace("-1 1 3", "-1 inf 3"), "q must be finite, got inf at index 1"),
    (BLOCKS.replace("3 3 2 1", "3 6 2 1"), "its blocks are not all 3 x 3"),
    (BLOCKS.replace("3 1 1 3 3 1 1 1", "3 1 1 3 3 1 2 1"), "1 contacts with 2 x 1 blocks"),
    (BLOCKS.replace("2 1 0 1 0 0", "3 1 0 1 0 0"), "the index lists must have 2 and 1 entries"),
    (BLOCKS.replace("2 1 0 1 0 0", "2 1 1 1 0 0"), "row pointers must rise from 0 to 1"),
    (BLOCKS.replace("2 1 0 1 0 0", "2 1 0 1 0 5"), "its blocks are not numbered in turn"),
]


@pytest.mark.parametrize(("text", "says"), BAD_TEXTS)
def test_a_bad_text_is_named_in_one_sentence(text: str, says: str, tmp_path: Path) -> None:
    path = tmp_path / "bad.dat"
    path.write_text(text)
    with pytest.raises((InvalidInputError, NotYetError), match=re.escape(says)) as raised:
        ContactProblem.read(path)
    assert str(raised.value).startswith(str(path)) and str(raised.value).endswith(".")


BAD_HDF5: list[tuple[dict[str, Any], str]] = [
    ({"spacedim": [2]}, "fclib_local/spacedim must be 3, got 2"),
    ({"V/m": [3]}, "fclib_local/V is a bilateral constraint"),
    ({"q": None}, "has no fclib_local/vectors/q"),
    ({"W/x": None}, "has no fclib_local/W/x"),
    ({"mu": [0.1, 0.2]}, "q must hold 6 numbers, got 3"),
    ({"W/m": [6]}, "W must be 3 x 3, as its vectors have it, got 6 x 3"),
    ({"q": [1.0, 2.0]}, "q must hold 3 numbers, got 2"),
    ({"nz": [-3]}, "must have nz = -2, -1 or a number of triplets, got -3"),
    ({"nz": [9]}, "must have 9 triplets, got 3, 4 and 3 numbers"),
    ({"p": [0, 1, 2]}, "must have 4 rising pointers p"),
    ({"p": [0, 2, 1, 3]}, "must have 4 rising pointers p"),
    ({"p": [0, 1, 2, 9]}, "must have 4 rising pointers p"),
    ({"i": [0, 1, 3]}, "is 3 x 3, but its indices reach from (0, 0) to (2, 3)"),
    ({"W/n": [4]}, "W must be 3 x 3, as its vectors have it, got 3 x 4"),
]


@pytest.mark.parametrize(("change", "says"), BAD_HDF5, ids=[next(iter(change)) for change, _ in BAD_HDF5])
def test_a_bad_fclib_file_is_named_in_one_sentence(change: dict[str, Any], says: str, tmp_path: Path) -> None:
    path = tmp_path / "bad.hdf5"
    if "mu" in change:
        write_local(path, mu=change["mu"], q=[-1.0, 0, 0])
    else:
        write_local(path, **change)
    with pytest.raises((InvalidInputError, NotYetError), match=re.escape(says)) as raised:
        ContactProblem.read(path)
    assert str(raised.value).startswith(str(path)) and str(raised.value).endswith(".")


def test_files_that_hold_something_else_are_named(tmp_path: Path) -> None:
    with h5py.File(tmp_path / "other.h5", "w") as file:
        file["frames"] = np.zeros(3)
    with pytest.raises(InvalidInputError, match="must hold a group fclib_local or fclib_global, it holds frames"):
        ContactProblem.read(tmp_path / "other.h5")
    with h5py.File(tmp_path / "rolling.h5", "w") as file:
        file.create_group("fclib_global_rolling")
    with pytest.raises(NotYetError, match="fclib_global_rolling"):
        ContactProblem.read(tmp_path / "rolling.h5")
    (tmp_path / "cut.h5").write_bytes((tmp_path / "other.h5").read_bytes()[:100])
    with pytest.raises(InvalidInputError, match=r"cut\.h5 is not a sound HDF5 file"):
        ContactProblem.read(tmp_path / "cut.h5")
    with pytest.raises(InvalidInputError, match=r"none\.h5 cannot be read: No such file"):
        ContactProblem.read(tmp_path / "none.h5")
    (tmp_path / "binary.dat").write_bytes(bytes(range(256)))
    with pytest.raises(InvalidInputError, match="not made of numbers alone"):
        ContactProblem.read(tmp_path / "binary.dat")


def test_what_cannot_be_written_is_said_before(tmp_path: Path) -> None:
    problem = ContactProblem(np.eye(3), [-1.0, 0, 0], 0.3)
    with pytest.raises(InvalidInputError, match="path must end in"):
        problem.write(tmp_path / "a.mat")
    with pytest.raises(InvalidInputError, match="this problem has none"):
        problem.write(tmp_path / "a.hdf5", form="global")
    with pytest.raises(OutputError):
        problem.write(tmp_path / "no" / "a.hdf5")
    assert list(tmp_path.iterdir()) == []


PAGES = Path("/proc/self/statm")
"""Where Linux says how many pages of memory this process has."""


@pytest.fixture
def little_memory() -> Iterator[None]:
    """Two gigabytes more than this process has now, and no more: HDF5 believes a damaged file that says it needs all
    the memory of the machine, whose kernel then ends the process."""
    if not PAGES.exists():
        yield
        return
    import resource

    before = resource.getrlimit(resource.RLIMIT_AS)
    has = int(PAGES.read_text().split()[0]) * resource.getpagesize()
    resource.setrlimit(resource.RLIMIT_AS, (has + 2 * 1024**3, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_AS, before)


@pytest.mark.skipif(not PAGES.exists(), reason="memory is limited on Linux only")
@pytest.mark.usefixtures("little_memory")
def test_a_file_that_asks_for_a_terabyte_is_refused(tmp_path: Path, rng: np.random.Generator) -> None:
    """For an array that was never written; and for each of its heaps of names, whose size is the second number after
    the signature (HDF5 file format, III.D)."""
    path = tmp_path / "local.hdf5"
    random_problem(rng, 2, 3).write(path, form="local")
    raw = path.read_bytes()
    with h5py.File(path, "a") as file:
        del file["fclib_local/vectors/mu"]
        file.create_dataset("fclib_local/vectors/mu", (1 << 37,), np.float64, chunks=(1 << 20,))
    with pytest.raises(InvalidInputError, match=r"local\.hdf5 is not a sound HDF5 file: Unable to allocate 1\.00 TiB"):
        ContactProblem.read(path)
    refused = 0
    for k in (k for k in range(len(raw)) if raw.startswith(b"HEAP", k)):
        path.write_bytes(raw[: k + 8] + (1 << 40).to_bytes(8, "little") + raw[k + 16 :])
        try:
            ContactProblem.read(path)  # without title and description, if their names are those that are lost
        except InvalidInputError as error:
            assert re.search(r"local\.hdf5 (is not a sound HDF5 file: |has no )", str(error))
            refused += 1
    assert refused > 0


@pytest.mark.usefixtures("little_memory")
@pytest.mark.parametrize("name", ["local.hdf5", "global.hdf5", "text.dat"])
def test_damaged_files_are_read_or_refused_but_never_crash(name: str, tmp_path: Path, rng: np.random.Generator) -> None:
    """A few bytes changed anywhere, or the end cut off: h5py has an exception of its own for each of them."""
    whole, damaged = tmp_path / name, tmp_path / "damaged"
    random_problem(rng, 2, 3).write(whole, form="global" if name == "global.hdf5" else "local")
    sound = np.frombuffer(whole.read_bytes(), np.uint8)
    digits = np.frombuffer(b"0123456789-.e \n", np.uint8)
    for _ in range(150):
        raw = sound.copy()
        places = rng.integers(len(raw), size=3)
        raw[places] = rng.choice(digits, size=3) if name == "text.dat" else rng.integers(256, size=3)
        damaged.write_bytes(raw[: rng.integers(len(raw)) if rng.random() < 0.1 else None].tobytes())
        try:
            ContactProblem.read(damaged)
        except StictionError as error:
            assert str(damaged) in str(error)
