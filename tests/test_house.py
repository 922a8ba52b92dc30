"""The rules of the house that no linter checks: light imports, a core that stands alone, short files, docstrings."""

from __future__ import annotations

import ast
import dataclasses
import enum
import inspect
import subprocess
import sys
from pathlib import Path

import pytest

import stiction

PACKAGE = Path(stiction.__file__).parent
CORE = PACKAGE / "core"
MAX_LINES = 600

HEAVY = {"gymnasium", "h5py", "matplotlib", "optuna", "pyarrow", "pydantic", "ray", "rich", "scipy", "typer", "viser"}
"""Packages that worlds, bodies and materials must leave alone: most programs use none of them."""

LATER = {"Batch", "BatchState", "Recording"}
"""Public names that belong to higher floors, which may load heavy packages."""

CORE_MAY_IMPORT = {"llvmlite", "numba", "numpy", *sys.stdlib_module_names}
"""llvmlite is the half of numba that writes machine code; lanes are made with it."""


def _top_level_imports(source: str, package: str) -> set[str]:
    """Names that a module imports, at any depth of the file: `stiction.x` in full, others by their first word."""
    names: set[str] = set()
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            names.update(alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            parts = package.split(".")
            parents = parts[: len(parts) - node.level + 1] if node.level else []
            module = ".".join([*parents, *([node.module] if node.module else [])])
            if module == "stiction":  # `from stiction import world` means stiction.world
                names.update(f"stiction.{alias.name}" for alias in node.names)
            else:
                names.add(module)
    return {name if name.split(".")[0] == "stiction" else name.split(".")[0] for name in names}


def _python_files(folder: Path) -> list[Path]:
    return sorted(folder.rglob("*.py"))


def _relative(path: Path) -> str:
    return path.relative_to(PACKAGE).as_posix()


def _own_docstring(thing: object) -> str:
    """The docstring that somebody wrote for this object: not inherited, not made by dataclass or Enum."""
    if not inspect.isclass(thing):
        return (inspect.getdoc(thing) or "").strip()
    text = (vars(thing).get("__doc__") or "").strip()
    if dataclasses.is_dataclass(thing) and text.startswith(f"{thing.__name__}("):
        return ""
    if issubclass(thing, tuple) and text.startswith(f"{thing.__name__}("):
        return ""
    if issubclass(thing, enum.Enum) and text == "An enumeration.":
        return ""
    return text


def _packages_loaded_by(code: str) -> set[str]:
    """Packages that a Python of its own has loaded after it has run this code."""
    code += "; import sys; print(*sorted({name.partition('.')[0] for name in sys.modules}))"
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    return set(result.stdout.split())


def test_importing_stiction_loads_nothing_yet() -> None:
    loaded = _packages_loaded_by("import stiction")
    assert "stiction" in loaded
    assert loaded & (HEAVY | CORE_MAY_IMPORT - set(sys.stdlib_module_names)) == set()


def test_commands_load_what_they_need_when_they_run() -> None:
    assert _packages_loaded_by("import stiction.cli.main") & (HEAVY - {"rich", "typer"} | {"numpy", "numba"}) == set()


def test_the_nouns_load_numpy_alone() -> None:
    nouns = sorted(set(stiction.__all__) - LATER)
    loaded = _packages_loaded_by(f"import stiction; {'; '.join(f'stiction.{name}' for name in nouns)}")
    assert "numpy" in loaded
    assert loaded & (HEAVY | {"numba", "llvmlite"}) == set()


def test_names_come_from_the_modules_that_type_checkers_are_told() -> None:
    tree = ast.parse((PACKAGE / "__init__.py").read_text(encoding="utf-8"))
    told = {
        alias.name: node.module for node in ast.walk(tree) if isinstance(node, ast.ImportFrom) for alias in node.names
    }
    for name in set(stiction.__all__) - {"__version__"}:
        assert told[name] == f"stiction.{stiction._MODULES[name]}"
    assert set(stiction._MODULES) == set(stiction.__all__) - {"__version__"}
    assert set(stiction.__all__) <= set(dir(stiction))
    with pytest.raises(AttributeError, match="has no attribute 'Wolrd'"):
        _ = stiction.Wolrd


@pytest.mark.parametrize("path", _python_files(CORE), ids=_relative)
def test_core_imports_only_numpy_numba_and_itself(path: Path) -> None:
    package = ".".join(["stiction", *path.relative_to(PACKAGE).parts[:-1]])
    imported = _top_level_imports(path.read_text(encoding="utf-8"), package)
    foreign = {
        name
        for name in imported
        if name not in CORE_MAY_IMPORT and name != "stiction.core" and not name.startswith("stiction.core.")
    }
    assert foreign == set()


@pytest.mark.parametrize(
    ("source", "imported"),
    [
        ("import numpy as np", {"numpy"}),
        ("import scipy.spatial", {"scipy"}),
        ("def f():\n    from matplotlib import pyplot", {"matplotlib"}),
        ("from stiction import world", {"stiction.world"}),
        ("from stiction.core import vec", {"stiction.core"}),
        ("from . import vec", {"stiction.core"}),
        ("from ..world import World", {"stiction.world"}),
        ("from .. import world", {"stiction.world"}),
    ],
)
def test_the_import_check_reads_every_form(source: str, imported: set[str]) -> None:
    assert _top_level_imports(source, "stiction.core") == imported


@pytest.mark.parametrize("path", _python_files(PACKAGE), ids=_relative)
def test_a_module_is_short_enough_to_read(path: Path) -> None:
    lines = len(path.read_text(encoding="utf-8").splitlines())
    assert lines <= MAX_LINES, f"{_relative(path)} has {lines} lines, {MAX_LINES} are allowed: split it by idea"


def test_public_names_exist_and_are_listed_once() -> None:
    assert len(stiction.__all__) == len(set(stiction.__all__))
    missing = [name for name in stiction.__all__ if not hasattr(stiction, name)]
    assert missing == []


@pytest.mark.parametrize("name", [name for name in stiction.__all__ if name != "__version__"])
def test_a_public_name_has_a_docstring(name: str) -> None:
    thing = getattr(stiction, name)
    assert inspect.isclass(thing) or inspect.isroutine(thing) or inspect.ismodule(thing)
    assert _own_docstring(thing), f"stiction.{name} has no docstring of its own"


def test_a_docstring_that_nobody_wrote_does_not_count() -> None:
    @dataclasses.dataclass
    class Generated:
        x: float

    class Inherited(ValueError):
        pass

    class Bare(enum.IntEnum):
        ONE = 1

    assert [_own_docstring(thing) for thing in (Generated, Inherited, Bare)] == ["", "", ""]
    assert _own_docstring(stiction.Box)


def test_the_version_is_written_once() -> None:
    places = [path for path in _python_files(PACKAGE) if "__version__ =" in path.read_text(encoding="utf-8")]
    assert [_relative(path) for path in places] == ["_version.py"]
    assert stiction.__version__ == vars(sys.modules["stiction._version"])["__version__"]
