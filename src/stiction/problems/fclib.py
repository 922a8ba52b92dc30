"""Contact problems in the HDF5 layout of FCLIB, the collection of frictional contact problems.

Acary, Brémond, Koziara, Pérignon, "FCLIB: a collection of discrete 3D Frictional Contact problems", INRIA RT-444
(2014), and the C interface fclib.h. A file holds either the local form, W and q, or the global one, M, H, f and w:

    fclib_local/spacedim, W/*, vectors/{q, mu}, info/{title, description, math_info}
    fclib_global/spacedim, M/*, H/*, vectors/{f, w, mu}, info/*

A matrix is stored as in CSparse: m, n, nzmax, and ``nz``, which says how to read the rest: -1 compressed columns
(p: n + 1 pointers, i: rows), -2 compressed rows (p: m + 1 pointers, i: columns), else the number of triplets (i: rows,
p: columns). Bilateral constraints (V, R, s; G, b) are not read.

Where the contacts of a problem are known they stand beside it, in a group of our own that other readers do not look at:

    stiction_places/{points, frames, bodies, impulses}
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from stiction.errors import InvalidInputError, NotYetError, OutputError, StictionError

if TYPE_CHECKING:
    from stiction.problems.problem import ContactPlaces, ContactProblem, Form

UNREADABLE = (OSError, RuntimeError, KeyError, ValueError, TypeError, MemoryError)
"""What h5py makes of damaged files, which may also say that they need any amount of memory."""
BY_COLUMNS, BY_ROWS = -1, -2
PLACES = "stiction_places"


def read(path: Path) -> ContactProblem:
    """The problem in an FCLIB file; a global one is reduced to W and q, and keeps its global form.

    Raises:
        InvalidInputError: something is missing or impossible; the sentence names the file and the place.
        NotYetError: the problem is planar, or has bilateral constraints or rolling friction.
    """
    import h5py

    from stiction.problems.problem import ContactProblem

    try:
        with h5py.File(path, "r") as file:
            group, form = _problem_group(path, file)
            mu = _vector(path, group, "vectors/mu")
            title, description = (_text(group, f"info/{name}") for name in ("title", "description"))
            texts: Any = {"title": title, "description": description, "places": _places(path, file, len(mu))}
            size = 3 * len(mu)
            if form == "local":
                W = _matrix(path, group, "W", (size, size))
                q = _vector(path, group, "vectors/q")
                return _checked(path, lambda: ContactProblem(W, q, mu, **texts))
            f, w = _vector(path, group, "vectors/f"), _vector(path, group, "vectors/w")
            M, H = _matrix(path, group, "M", (len(f), len(f))), _matrix(path, group, "H", (len(f), size))
            return _checked(path, lambda: ContactProblem.from_global(M, H, f, w, mu, **texts))
    except StictionError:
        raise
    except UNREADABLE as error:
        reason = error.args[0] if isinstance(error, KeyError) else str(error) or "it asks for too much memory"
        raise InvalidInputError(f"{path} is not a sound HDF5 file: {reason}.") from None


def _checked(path: Path, make: Any) -> ContactProblem:
    """What a value says of its own input, with the file before it."""
    try:
        made: ContactProblem = make()
    except InvalidInputError as error:
        raise InvalidInputError(f"{path}: {error}") from None
    return made


def _problem_group(path: Path, file: Any) -> tuple[Any, str]:
    """The one group that holds the problem, after everything that is not for us is refused."""
    for form, others in (("local", ("V", "R")), ("global", ("G",))):
        name = f"fclib_{form}"
        if name not in file:
            continue
        group = file[name]
        space = _whole(path, group, "spacedim")[0]
        if space != 3:
            raise NotYetError(f"{path}: {name}/spacedim must be 3, got {space}; planar problems are not read.")
        for other in others:
            if other in group:
                raise NotYetError(f"{path}: {name}/{other} is a bilateral constraint; only contacts are read.")
        return group, form
    found = ", ".join(sorted(map(str, file))) or "nothing"
    rolling = "rolling" in found
    kind: type[Exception] = NotYetError if rolling else InvalidInputError
    raise kind(f"{path} must hold a group fclib_local or fclib_global, it holds {found}.")


def _vector(path: Path, group: Any, name: str) -> NDArray[np.float64]:
    import h5py

    place = f"{group.name.lstrip('/')}/{name}"
    found = group.get(name)
    if not isinstance(found, h5py.Dataset):
        raise InvalidInputError(f"{path} has no {place}.")
    if found.dtype.kind not in "iuf" or found.size == 0:
        raise InvalidInputError(f"{path}: {place} must be numbers, got {found.size} of type {found.dtype}.")
    return np.asarray(found[()], dtype=np.float64).reshape(-1)


def _whole(path: Path, group: Any, name: str) -> NDArray[np.int64]:
    found = _vector(path, group, name)
    if not (np.abs(found) < 2.0**53).all() or (found != np.floor(found)).any():
        raise InvalidInputError(f"{path}: {group.name.lstrip('/')}/{name} must be whole numbers.")
    return found.astype(np.int64)


def _text(group: Any, name: str) -> str:
    import h5py

    found = group.get(name)
    if not isinstance(found, h5py.Dataset) or found.shape != ():
        return ""
    value = found[()]
    return value.decode("utf-8", "replace") if isinstance(value, bytes) else str(value)


def _places(path: Path, file: Any, n: int) -> ContactPlaces | None:
    """Where the contacts are, if the file says so."""
    from stiction.problems.problem import ContactPlaces

    if PLACES not in file:
        return None
    shapes = {"points": (n, 3), "frames": (n, 3, 3), "bodies": (n, 2), "impulses": (n, 3)}
    found: dict[str, Any] = {}
    for name, shape in shapes.items():
        values = (_whole if name == "bodies" else _vector)(path, file[PLACES], name)
        if values.size != np.prod(shape):
            raise InvalidInputError(f"{path}: {PLACES}/{name} must hold {np.prod(shape)} numbers, got {values.size}.")
        found[name] = values.reshape(shape)
    return ContactPlaces(**found)


def _matrix(path: Path, group: Any, name: str, shape: tuple[int, int]) -> Any:
    """A sparse matrix in any of the three storages, which must have the shape that the vectors ask for."""
    from scipy.sparse import coo_array

    place = f"{path}: {group.name.lstrip('/')}/{name}"
    m, n, nz = (_whole(path, group, f"{name}/{key}")[0] for key in ("m", "n", "nz"))
    if (m, n) != shape:
        raise InvalidInputError(f"{place} must be {shape[0]} x {shape[1]}, as its vectors have it, got {m} x {n}.")
    p, i = (_whole(path, group, f"{name}/{key}") for key in ("p", "i"))
    x = _vector(path, group, f"{name}/x")
    if nz < BY_ROWS:
        raise InvalidInputError(f"{place} must have nz = -2, -1 or a number of triplets, got {nz}.")
    if nz >= 0:
        if min(len(p), len(i), len(x)) < nz:
            raise InvalidInputError(f"{place} must have {nz} triplets, got {len(i)}, {len(p)} and {len(x)} numbers.")
        i, j, x = i[:nz], p[:nz], x[:nz]
    else:
        lines = n if nz == BY_COLUMNS else m
        if len(p) != lines + 1 or p[0] != 0 or (np.diff(p) < 0).any() or min(len(i), len(x)) < p[-1]:
            raise InvalidInputError(
                f"{place} must have {lines + 1} rising pointers p that begin at 0 and end within i and x; "
                f"got {len(p)} from {p[0]} to {p[-1]} with {len(i)} indices and {len(x)} values."
            )
        along = np.repeat(np.arange(lines), np.diff(p))
        across, x = i[: p[-1]], x[: p[-1]]
        i, j = (across, along) if nz == BY_COLUMNS else (along, across)
    if len(x) and (i.min() < 0 or i.max() >= m or j.min() < 0 or j.max() >= n):
        raise InvalidInputError(
            f"{place} is {m} x {n}, but its indices reach from ({i.min()}, {j.min()}) to ({i.max()}, {j.max()})."
        )
    return coo_array((x, (i, j)), shape=shape)


# --- writing ---------------------------------------------------------------------------------------------------------


def write(problem: ContactProblem, path: Path, form: Form) -> None:
    """Write a problem as FCLIB does; W by rows, M and H by columns.

    Raises:
        OutputError: the file cannot be written.
    """
    import h5py

    try:
        with h5py.File(path, "w") as file:
            group = file.create_group(f"fclib_{form}")
            group["spacedim"] = np.array([3], np.int32)
            vectors = {"mu": problem.mu}
            if form == "local":
                _put(group, "W", problem.W.sparse(), BY_ROWS)
                vectors["q"] = problem.q
            else:
                bodies = problem.global_form
                assert bodies is not None
                _put(group, "M", bodies.M, BY_COLUMNS)
                _put(group, "H", bodies.H, BY_COLUMNS)
                vectors |= {"f": bodies.f, "w": bodies.w}
            for name, values in vectors.items():
                group[f"vectors/{name}"] = values
            texts = {"title": problem.title, "description": problem.description, "math_info": ""}
            for name, text in texts.items():
                group[f"info/{name}"] = np.bytes_(text.encode("utf-8") + b"\0")
            if problem.places is not None:
                for name, values in vars(problem.places).items():
                    file[f"{PLACES}/{name}"] = values
    except OSError as error:
        raise OutputError(f"{path} cannot be written: {error}.") from None


def _put(group: Any, name: str, matrix: Any, nz: int) -> None:
    matrix.sort_indices()
    m, n = matrix.shape
    scalars = {"m": m, "n": n, "nz": nz, "nzmax": matrix.nnz}
    for key, value in scalars.items():
        group[f"{name}/{key}"] = np.array([value], np.int32)
    group[f"{name}/p"] = matrix.indptr.astype(np.int32)
    group[f"{name}/i"] = matrix.indices.astype(np.int32)
    group[f"{name}/x"] = matrix.data
