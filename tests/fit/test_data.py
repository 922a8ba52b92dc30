"""CSV files of measured motion: what they may hold, and one sentence for each thing that is wrong."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from stiction.errors import InvalidInputError
from stiction.fit import Track, read_csv


def written(folder: Path, text: str) -> Path:
    file = folder / "data.csv"
    file.write_text(text)
    return file


def test_a_file_may_leave_out_columns_and_samples(tmp_path: Path) -> None:
    (track,) = read_csv(written(tmp_path, "# a ruler\n x , t\n0.5,0\n,0.1\nnan,0.25\n0.75,0.5\n"))
    assert track.body == "" and track.orientations is None and track.count == 2
    np.testing.assert_array_equal(track.times, [0.0, 0.1, 0.25, 0.5])
    np.testing.assert_array_equal(track.positions[:, 0], [0.5, np.nan, np.nan, 0.75])
    assert np.isnan(track.positions[:, 1:]).all()


def test_a_file_holds_many_bodies_and_orientations(tmp_path: Path) -> None:
    text = "t,body,x,y,z,qw,qx,qy,qz\n0,b,1,2,3,1.001,0,0,0\n0,a,4,5,6,,,,\n0.1,b,1,2,3,0.6,0.8,0,0\n"
    b, a = read_csv(written(tmp_path, text))
    assert (b.body, a.body, len(b), len(a)) == ("b", "a", 2, 1)
    assert b.orientations is not None and a.orientations is not None
    np.testing.assert_allclose(np.linalg.norm(b.orientations, axis=1), 1.0, rtol=1e-15)
    assert (b.count, a.count) == (12, 3) and np.isnan(a.orientations).all()


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("", "must hold a line of column names and samples, got nothing."),
        ("t,x\n", "must hold samples below the column names, got none."),
        ("time,x\n0,0\n", "columns must be among t, x, y, z, qw, qx, qy, qz, body, got 'time'"),
        ("x,y\n0,0\n", "column t, the time in s, must be there, got x, y."),
        ("t,body\n0,a\n", "at least one of the columns x, y, z, in m, must be there"),
        ("t,x,x\n0,0,0\n", "column 'x' must be there once, got it 2 times."),
        ("t,x,qw,qx\n0,0,1,0\n", "columns qw, qx, qy, qz must be there all four or not at all, got qw, qx."),
        ("t,x\n0,1\n0.1,1.2m\n", "line 3: x must be a number or empty, got '1.2m'."),
        ("t,x\n0,inf\n", "line 2: x must be finite or empty, got 'inf'."),
        ("t,x\n,1\n", "line 2: t must be a time in s, got ''."),
        ("t,x\n-1,1\n", "line 2: t must be 0 s or more, counted from the start of the scene, got -1."),
        ("t,x\n0,1\n0.2,1\n\n0.1,1\n", "line 5: t must be later than 0.2 s, that of the sample before, got 0.1."),
        ("t,x\n0,1,2\n", "line 2: must have 2 cells, as the header has, got 3."),
        ("t,x,body\n0,1,\n", "line 2: body must be the name of a body, got nothing."),
        ("t,x,qw,qx,qy,qz\n0,1,1,0,0,\n", "line 2: qw, qx, qy, qz must be there all four or not at all."),
        ("t,x,qw,qx,qy,qz\n0,1,2,0,0,0\n", "line 2: qw, qx, qy, qz must have length 1, got 2."),
    ],
)
def test_what_is_wrong_is_named_with_its_line(text: str, sentence: str, tmp_path: Path) -> None:
    with pytest.raises(InvalidInputError) as caught:
        read_csv(written(tmp_path, text))
    assert sentence in str(caught.value)


def test_a_file_that_is_not_there(tmp_path: Path) -> None:
    with pytest.raises(InvalidInputError, match=r"data file must exist, got '.*none\.csv'"):
        read_csv(tmp_path / "none.csv")


def test_shapes_of_a_track_are_checked() -> None:
    with pytest.raises(InvalidInputError, match=r"positions must have shape \(2, 3\), got shape \(3, 3\)"):
        Track("", np.zeros(2), np.zeros((3, 3)))
    with pytest.raises(InvalidInputError, match=r"orientations must have shape \(2, 4\)"):
        Track("", np.zeros(2), np.zeros((2, 3)), np.zeros((3, 4)))
