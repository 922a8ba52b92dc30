"""A contact problem as a value: the impulses of n contacts that act at the same instant, and nothing around them.

What one step of any engine has to solve, taken out of the engine. With the normal component first in every block of
three, the velocities u (u_n positive where bodies part) and impulses r of all contacts obey

    u = W r + q,      r in K:  |r_t| <= mu r_n,

    u_n >= 0,  r_n >= 0,  u_n r_n = 0                                   (Signorini)
    r_t = -mu r_n u_t / |u_t|  where u_t is not 0                       (Coulomb)

W is Delassus' operator H^T M^-1 H (3n x 3n, symmetric, positive semidefinite), q the velocity without any impulse.
"""

from __future__ import annotations

from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stiction import checks, outputs
from stiction.errors import InvalidInputError
from stiction.problems.blocks import BlockMatrix

if TYPE_CHECKING:
    from scipy.sparse import csc_array

Vector = NDArray[np.float64]
Form = Literal["local", "global"]

COLUMNS = 300
"""Of H that M^-1 is applied to at a time."""


@dataclass(frozen=True, eq=False)
class GlobalForm:
    """The same problem with the bodies in it: M v = H r + f, u = H^T v + w, with v the velocities of the bodies.

    Attributes:
        M: masses, (d, d), for d velocities of all bodies.
        H: takes impulses to bodies, (d, 3n); its transpose takes their velocities to those of the contacts.
        f: momenta that the bodies have without any contact, (d,).
        w: part of u that is not the bodies' own, (3n,).
    """

    M: csc_array
    H: csc_array
    f: Vector
    w: Vector


@dataclass(frozen=True, eq=False)
class ContactPlaces:
    """Where the contacts of a problem are, for one that was taken out of a world.

    Attributes:
        points: (n, 3), m.
        frames: (n, 3, 3): the columns are the normal, from body a to body b, and the two directions in the plane, in
            which the blocks of three are written.
        bodies: (n, 2), indices of a and b in the world.
        impulses: (n, 3) in N s, what the world's own solver gives these points in that step, on b, the normal
            component first. The friction of a face acts on it as a whole and is told at its points by their loads.
    """

    points: Vector
    frames: Vector
    bodies: NDArray[np.int64]
    impulses: Vector


class ContactProblem:
    """n contacts with dry friction: W (3n x 3n), q (3n,) and mu (n,), the normal component first in each block of 3.

    Args:
        W: the Delassus operator: a dense array, a scipy sparse matrix or a :class:`BlockMatrix`, (3n, 3n).
        q: velocities u without impulses, (3n,) or (n, 3), in m/s for W in 1/kg and r in N s.
        mu: coefficients of friction, (n,) or one number for all.
        title: a name to show.
        description: where it is from.
        global_form: the same problem with the bodies in it, if it is known.
        places: where the contacts are, if it is known.

    Raises:
        InvalidInputError: a shape does not fit, a number is not finite, or a coefficient is below zero.

    >>> import numpy as np
    >>> from stiction.problems import ContactProblem
    >>> problem = ContactProblem(np.eye(3), q=[-1.0, 0.5, 0.0], mu=0.3)
    >>> problem.contacts
    1
    """

    def __init__(
        self,
        W: Any,
        q: ArrayLike,
        mu: ArrayLike,
        *,
        title: str = "",
        description: str = "",
        global_form: GlobalForm | None = None,
        places: ContactPlaces | None = None,
    ) -> None:
        blocks = W if isinstance(W, BlockMatrix) else BlockMatrix.of(W)
        n = blocks.rows
        self.W = blocks
        self.q = _finite("q", np.array(q, dtype=np.float64).reshape(-1), 3 * n)
        coefficients = np.array(mu, dtype=np.float64)
        self.mu = _finite("mu", np.full(n, coefficients) if coefficients.ndim == 0 else coefficients.reshape(-1), n)
        if n and self.mu.min() < 0.0:
            raise InvalidInputError(f"mu must be 0 or more, got {self.mu.min():g} at contact {self.mu.argmin()}.")
        self.title = title
        self.description = description
        self.global_form = global_form
        self.places = places
        for array in (self.q, self.mu):
            array.flags.writeable = False

    @property
    def contacts(self) -> int:
        """Number of contacts n."""
        return self.W.rows

    def __repr__(self) -> str:
        name = f"{self.title!r}, " if self.title else ""
        return f"<ContactProblem: {name}{self.contacts} contacts, {len(self.W.indices)} blocks>"

    @classmethod
    def from_global(
        cls,
        M: Any,
        H: Any,
        f: ArrayLike,
        w: ArrayLike,
        mu: ArrayLike,
        *,
        title: str = "",
        description: str = "",
        places: ContactPlaces | None = None,
    ) -> ContactProblem:
        """The problem of bodies with masses M (d, d) and contacts H (d, 3n): M v = H r + f, u = H^T v + w.

        The velocities v are eliminated: W = H^T M^-1 H and q = w + H^T M^-1 f. The global form is kept.

        Raises:
            InvalidInputError: shapes do not fit, or M is singular.
        """
        from scipy.sparse import csc_array, hstack
        from scipy.sparse.linalg import splu

        M, H = csc_array(M, dtype=np.float64), csc_array(H, dtype=np.float64)
        d, m = H.shape
        if M.shape != (d, d) or m % 3:
            raise InvalidInputError(f"M must be (d, d) and H (d, 3n), got {M.shape} and {H.shape}.")
        momentum = _finite("f", np.array(f, dtype=np.float64).reshape(-1), d)
        moving = _finite("w", np.array(w, dtype=np.float64).reshape(-1), m)
        if not (np.isfinite(M.data).all() and np.isfinite(H.data).all()):
            raise InvalidInputError("M and H must be finite.")
        try:
            inverse = splu(M)
        except RuntimeError:
            raise InvalidInputError(f"M must not be singular, got a singular ({d}, {d}) matrix.") from None
        # M^-1 H is nearly as sparse as H, but comes out of the solver dense: a few columns at a time
        starts = range(0, m, COLUMNS)
        moved = [csc_array(inverse.solve(H[:, start : start + COLUMNS].toarray())) for start in starts]
        W = H.T @ (hstack(moved, format="csc") if moved else H)
        q = moving + H.T @ inverse.solve(momentum)
        form = GlobalForm(M, H, momentum, moving)
        return cls(W, q, mu, title=title, description=description, global_form=form, places=places)

    @classmethod
    def read(cls, path: str | PathLike[str]) -> ContactProblem:
        """A problem from a file in FCLIB's HDF5 layout or in Siconos' text format, told apart by what is in it.

        Raises:
            InvalidInputError: the file is not there, is neither, or says something impossible; the sentence names it.
        """
        from stiction.problems import fclib, siconos

        file = Path(path)
        try:
            with file.open("rb") as stream:
                is_hdf5 = stream.read(8) == b"\x89HDF\r\n\x1a\n"
        except OSError as error:
            raise InvalidInputError(f"{file} cannot be read: {error.strerror or error}.") from None
        return fclib.read(file) if is_hdf5 else siconos.read(file)

    def write(self, path: str | PathLike[str], *, form: Form | None = None) -> None:
        """Write it: ``.hdf5`` or ``.h5`` in FCLIB's layout, ``.dat`` or ``.txt`` in Siconos' text format.

        Args:
            path: the file; its folder must be there.
            form: "local" for W and q, "global" for M, H, f and w (FCLIB only); the global form if there is one.

        Raises:
            InvalidInputError: the ending is another one, or there is no global form to write.
            OutputError: the file cannot be written.
        """
        from stiction.problems import fclib, siconos

        file = Path(path)
        in_hdf5 = check_ending("path", file) in (".hdf5", ".h5")
        if form is None:
            form = "global" if in_hdf5 and self.global_form is not None else "local"
        checks.one_of("form", form, ("local", "global"))
        if form == "global" and (self.global_form is None or not in_hdf5):
            why = "this problem has none" if self.global_form is None else "Siconos' text format here has only W and q"
            raise InvalidInputError(f"form='global' cannot be written to {file}: {why}.")
        outputs.writable("path", file)
        if in_hdf5:
            fclib.write(self, file, form)
        else:
            siconos.write(self, file)


def check_ending(name: str, path: Path) -> str:
    """The ending of a file to write, in small letters.

    Raises:
        InvalidInputError: it names no known format.
    """
    ending = path.suffix.lower()
    if ending not in (".hdf5", ".h5", ".dat", ".txt"):
        raise InvalidInputError(f"{name} must end in .hdf5, .h5 (FCLIB), .dat or .txt (Siconos), got {str(path)!r}.")
    return ending


def _finite(name: str, array: Vector, size: int) -> Vector:
    if array.shape != (size,):
        raise InvalidInputError(f"{name} must hold {size} numbers, got {array.size}.")
    bad = ~np.isfinite(array)
    if bad.any():
        raise InvalidInputError(f"{name} must be finite, got {array[bad][0]} at index {int(bad.argmax())}.")
    return array
