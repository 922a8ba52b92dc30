"""Rows in pieces: what was written is read again, whole or in parts, while it grows; no place in the file is lost."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from numpy.typing import NDArray

from stiction.record.columns import PackedColumn, pack
from stiction.record.packed import PackedRows

Rows = NDArray[Any]


def new_file(path: Path) -> h5py.File:
    return h5py.File(path, "w", libver=("v110", "v110"))


def numbers(dtype: str, shape: tuple[int, ...]) -> Rows:
    return np.random.default_rng(0).normal(scale=100.0, size=shape).astype(dtype)


@pytest.mark.parametrize(("dtype", "order"), [("f4", 2), ("f2", 1), ("f8", 2), ("i2", 2), ("u1", 0)])
def test_rows_are_read_while_they_grow(dtype: str, order: int, tmp_path: Path) -> None:
    rows = numbers(dtype, (50, 300, 3))
    with new_file(tmp_path / "x.h5") as file:
        column = PackedColumn(file, "x", dtype, (300, 3), 16, order)
        file.swmr_mode = True
        with h5py.File(tmp_path / "x.h5", "r", libver="latest", swmr=True) as other:
            reader = PackedRows(other, "x")
            for k in range(0, 50, 5):
                column.add(rows[k : k + 5])
                column.write(everything=True)
                assert column.length == k + 5
                reader.refresh()
                assert reader.packed == (k + 5) // 16 * 16
                reader.keep(k + 5)
                for part in (slice(0, k + 5), slice(k, k + 3), slice(17, 18), slice(3, 3), slice(k // 2, k + 4)):
                    assert reader.read(part).tobytes() == rows[: k + 5][part].tobytes()
                    assert reader.read(part, 299).tobytes() == rows[: k + 5][part][:, 299].tobytes()
            column.finish()
            reader.refresh()
            reader.keep(50)
            assert reader.packed == 50
            assert reader.read(slice(0, 50)).tobytes() == rows.tobytes()


@pytest.mark.parametrize(("dtype", "order"), [("f4", 2), ("i2", 2), ("f8", 1)])
def test_where_a_body_was_not_there_yet_rows_hold_nothing(dtype: str, order: int, tmp_path: Path) -> None:
    """In pieces before, in the piece in which it came, in the tail, and where it is in a piece of its own."""
    rows = numbers(dtype, (30, 600, 3))
    nothing = np.full((1, 1, 1), np.nan if np.dtype(dtype).kind == "f" else 0).astype(dtype)
    with new_file(tmp_path / "x.h5") as file:
        column = PackedColumn(file, "x", dtype, (2, 3), 8, order)
        reader = PackedRows(file, "x")
        expected = np.broadcast_to(nothing, rows.shape).copy()
        for k, bodies in enumerate([*(2,) * 10, *(3,) * 3, *(4,) * 8, *(600,) * 9]):
            expected[k, :bodies] = rows[k, :bodies]
            column.add(rows[k : k + 1, :bodies])
            column.write(everything=k % 2 == 0)
            reader.refresh()
            reader.keep(column.length)
            assert (
                reader.read(slice(0, column.length)).tobytes() == expected[: column.length, : reader.bodies].tobytes()
            )
        column.finish()
        reader.refresh()
        reader.keep(30)
        assert reader.read(slice(0, 30)).tobytes() == expected.tobytes()
        assert reader.read(slice(5, 25), 3).tobytes() == expected[5:25, 3].tobytes()


def test_a_row_is_in_the_file_at_the_second_time_of_asking(tmp_path: Path) -> None:
    rows = numbers("f4", (40, 5, 3))
    with new_file(tmp_path / "x.h5") as file:
        column = PackedColumn(file, "x", "f4", (5, 3), 16, 2)
        lengths = []
        for k in range(40):
            column.add(rows[k : k + 1])
            column.write(everything=False)
            lengths.append(column.length)
        missing = np.arange(1, 41) - lengths
        assert set(missing[[0, 16, 32]]) == {1}, "the first of each piece waits"
        assert missing.sum() == 3


def test_a_piece_that_grows_slowly_takes_no_more_place_than_one_that_comes_at_once(tmp_path: Path) -> None:
    rows = numbers("f8", (96, 200, 3))
    sizes = {}
    for at_once in (1, 96):
        path = tmp_path / f"{at_once}.h5"
        with new_file(path) as file:
            column = PackedColumn(file, "x", "f8", (200, 3), 32, 2)
            file.swmr_mode = True
            for k in range(0, 96, at_once):
                column.add(rows[k : k + at_once])
                column.write(everything=True)
            column.finish()
            sizes[at_once] = path.stat().st_size
    tail = 32 * 200 * 3 * 8
    assert sizes[96] < sizes[1] < sizes[96] + 1.5 * tail


def test_rows_of_one_item_are_packed_alike(tmp_path: Path) -> None:
    dtype = np.dtype([("step", "<i8"), ("body", "<i4"), ("what", "u1")])
    rows = np.zeros(100, dtype)
    rows["step"], rows["body"], rows["what"] = np.arange(100) // 4, np.arange(100) % 4, 5
    with new_file(tmp_path / "x.h5") as file:
        column = PackedColumn(file, "x", dtype, (), 32)
        reader = PackedRows(file, "x")
        for k in range(0, 100, 10):
            column.add(rows[k : k + 10])
            column.write(everything=True)
            reader.refresh()
            reader.keep(k + 10)
            np.testing.assert_array_equal(reader.read(slice(0, k + 10)), rows[: k + 10])
        column.finish()
        np.testing.assert_array_equal(file["x"][:], rows)


def test_hdf5_undoes_what_was_packed(tmp_path: Path) -> None:
    """Its own filters do, whatever the strategy of deflating."""
    rows = numbers("f4", (8, 5, 3))
    for order in (0, 1):
        with new_file(tmp_path / "x.h5") as file:
            made = file.create_dataset(
                "x", data=np.zeros_like(rows), chunks=rows.shape, compression="gzip", shuffle=True
            )
            made.id.write_direct_chunk((0, 0, 0), pack(rows, order))
        with h5py.File(tmp_path / "x.h5") as file:
            np.testing.assert_array_equal(file["x"][:], rows)
