"""A folder of contact problems, measured."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from stiction.errors import InvalidInputError
from stiction.problems import ContactProblem
from stiction.verify.problems import COUNTS, DEFAULT, ProblemResult, Skipped, measure, measure_files, problem_files

K = np.diag([1.0, 1.0, 4.0])
ANISOTROPIC = ContactProblem(K, [-1.0, 1.0, 1.0], 0.2)


def test_every_local_solver_is_measured_and_the_clamp_stalls() -> None:
    result = measure(ANISOTROPIC, "one")
    assert set(result.errors) == {"secular", "alternate", "newton", "projection", "clamp", DEFAULT}
    assert all(tuple(errors) == COUNTS for errors in result.errors.values())
    last = {local: errors[1000] for local, errors in result.errors.items()}
    clamp = last.pop("clamp")
    assert clamp is not None and clamp > 1e-2
    assert all(error is not None and error < 1e-6 for error in last.values())
    assert result.converged and result.contacts == 1 and result.mu == (0.2, 0.2)


def test_where_time_is_up_the_rest_is_not_known() -> None:
    result = measure(ANISOTROPIC, "one", seconds=1e-9)
    assert [result.errors["secular"][count] is None for count in COUNTS] == [False, True, True]


def test_a_limit_on_sweeps_may_be_too_low() -> None:
    result = measure(ANISOTROPIC, "one", sweeps=0, tolerance=1e-300, seconds=1e-9)
    assert not result.converged and result.sweeps == 0 and result.newton_steps == 0


def test_files_are_taken_by_name_and_bad_ones_are_told_apart(tmp_path: Path) -> None:
    ANISOTROPIC.write(tmp_path / "b.dat")
    ANISOTROPIC.write(tmp_path / "c.v2.hdf5")
    (tmp_path / "a.txt").write_text("hello")
    (tmp_path / "README.md").write_text("hello")
    files = problem_files(tmp_path)
    assert [file.name for file in files] == ["a.txt", "b.dat", "c.v2.hdf5"]
    told: list[str] = []
    bad, first, second = measure_files(files, progress=told.append)
    assert isinstance(bad, Skipped) and bad.file == "a.txt" and "not made of numbers alone" in bad.reason
    assert isinstance(first, ProblemResult) and isinstance(second, ProblemResult)
    assert told == ["a", "b", "c"] == ["a", first.problem, second.problem]


def test_a_folder_without_problems_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InvalidInputError, match=r"--fclib must be a folder with files \.hdf5"):
        problem_files(tmp_path)
    with pytest.raises(InvalidInputError, match="--fclib must be a folder, got"):
        problem_files(tmp_path / "none")
