"""Recordings for other programs, read back with what others wrote."""

from __future__ import annotations

import json
import struct
from pathlib import Path

import numpy as np
import pytest

import stiction as st
from stiction import InvalidInputError, OutputError
from stiction.record import export
from stiction.record.gltf import write_glb

from .worlds import tower


@pytest.fixture(scope="module")
def path(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """One body comes late, another goes; a ball lies still."""
    path = tmp_path_factory.mktemp("export") / "run.h5"
    world = tower()
    world.add(st.Sphere(0.2), position=(9, 9, 9), kinematic=True, material="ice")
    with world.record(path, every=5, title="a tower"):
        world.step(30)
        world.add(st.Sphere(0.3), position=(5, 5, 3), name="late")
        world.step(10)
        world.remove(world["box 1"])
        world.step(40)
    return path


def test_a_dataset_has_names_and_units(path: Path) -> None:
    pytest.importorskip("xarray", reason="of the extra `data`")
    with st.Recording.open(path) as recording:
        data = recording.to_xarray()
        np.testing.assert_array_equal(data.positions.sel(body="box 3"), recording.positions("box 3"))
        assert data.sizes == {"time": 17, "body": 7, "axis": 3, "component": 4}
        assert data.velocities.attrs["units"] == "m s-1"
        assert float(data.positions.sel(time=0.5, body="box 2", axis="z")) == recording.positions("box 2")[6, 2]
        assert recording.to_xarray(0.5, 0.75).sizes["time"] == 4


def test_a_netcdf_file_opens(path: Path, tmp_path: Path) -> None:
    xarray = pytest.importorskip("xarray", reason="of the extra `data`")
    with st.Recording.open(path) as recording:
        recording.export(tmp_path / "run.nc")
        with xarray.open_dataset(tmp_path / "run.nc") as data:
            np.testing.assert_array_equal(data.positions, recording.positions())
            assert data.attrs["title"] == "a tower"


def test_a_table_has_a_row_a_body_and_frame(path: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    parquet = pytest.importorskip("pyarrow.parquet", reason="of the extra `data`")
    monkeypatch.setattr(export, "TABLE_ROWS", 30)  # in several pieces
    with st.Recording.open(path) as recording:
        recording.to_parquet(tmp_path / "run.parquet", 0.25)
        table = parquet.read_table(tmp_path / "run.parquet").to_pydict()
        frames = recording.frames(0.25)
    f, n = frames.positions.shape[:2]
    assert len(table["time"]) == f * n == 14 * 7
    np.testing.assert_array_equal(np.reshape(table["time"], (f, n))[:, 0], frames.times)
    assert table["step"][-1] == 80
    assert table["body"][:n] == [body.name for body in frames.bodies]
    for k, name in enumerate(("x", "y", "z")):
        np.testing.assert_array_equal(np.reshape(table[name], (f, n)), frames.positions[:, :, k])
    np.testing.assert_array_equal(np.reshape(table["qz"], (f, n)), frames.orientations[:, :, 3])
    np.testing.assert_array_equal(np.reshape(table["wx"], (f, n)), frames.angular_velocities[:, :, 0])


def test_an_animation_opens_with_another_reader(path: Path, tmp_path: Path) -> None:
    pygltflib = pytest.importorskip("pygltflib", reason="of the extra `dev`")
    with st.Recording.open(path) as recording:
        recording.export(tmp_path / "run.glb")
        frames = recording.frames()
    scene = pygltflib.GLTF2().load(str(tmp_path / "run.glb"))
    blob = scene.binary_blob()

    def numbers(accessor: int) -> np.ndarray:
        told = scene.accessors[accessor]
        view = scene.bufferViews[told.bufferView]
        assert told.componentType == pygltflib.FLOAT
        width = {"SCALAR": 1, "VEC3": 3, "VEC4": 4}[told.type]
        assert view.byteLength == 4 * width * told.count and view.byteOffset % 4 == 0
        values = np.frombuffer(blob, "<f4", told.count * width, view.byteOffset).reshape(told.count, width)
        if told.min:
            np.testing.assert_array_equal(values.min(axis=0), np.float32(told.min))
            np.testing.assert_array_equal(values.max(axis=0), np.float32(told.max))
        return values

    names = {node.name: number for number, node in enumerate(scene.nodes)}
    assert set(names) == {"z up", *(body.name for body in frames.bodies)}
    assert scene.nodes[names["z up"]].children == [names[body.name] for body in frames.bodies]
    animation = scene.animations[0]
    tracks = {(one.target.node, one.target.path): animation.samplers[one.sampler] for one in animation.channels}
    box = names["box 3"]
    sampler = tracks[box, "translation"]
    times, places = numbers(sampler.input)[:, 0], numbers(sampler.output)
    assert (np.diff(times) > 0).all() and times[0] == 0.0
    for k, name in enumerate("xyz"):
        played = np.interp(frames.times, times, places[:, k])
        np.testing.assert_allclose(played, frames.positions[:, 3, k], atol=1e-5, err_msg=name)
    turns = numbers(tracks[box, "rotation"].output)
    np.testing.assert_allclose(np.linalg.norm(turns, axis=1), 1.0, rtol=1e-6)
    assert (np.sum(turns[1:] * turns[:-1], axis=1) > 0).all(), "players turn the short way"
    np.testing.assert_allclose(turns[-1, 3], abs(frames.orientations[-1, 3, 0]), atol=1e-6)

    still = [names["plane 0"], names["sphere 5"]]
    assert not [key for key in tracks if key[0] in still], "what does not move has no tracks"
    sizes = numbers(tracks[names["late"], "scale"].output)[:, 0]
    assert sizes[0] < 1e-3 and sizes[-1] == 1.0
    assert numbers(tracks[names["box 1"], "scale"].output)[-1, 0] < 1e-3
    boxes = {scene.nodes[names[f"box {k}"]].mesh for k in range(1, 5)}
    assert len(boxes) == 1, "equal bodies share a mesh"
    for mesh in scene.meshes:
        normals = numbers(mesh.primitives[0].attributes.NORMAL)
        np.testing.assert_allclose(np.linalg.norm(normals, axis=1), 1.0, rtol=1e-5)


def test_an_animation_is_where_the_bodies_are(path: Path, tmp_path: Path) -> None:
    trimesh = pytest.importorskip("trimesh", reason="of the extra `mesh`")
    with st.Recording.open(path) as recording:
        recording.export(tmp_path / "run.glb", 0.25, 0.25)
        frames = recording.frames(0.25, 0.25)
    scene = trimesh.load_scene(tmp_path / "run.glb")
    turn = np.array([[1, 0, 0, 0], [0, 0, 1, 0], [0, -1, 0, 0], [0, 0, 0, 1.0]])  # z up becomes y up
    for number, body in enumerate(frames.bodies[:5]):
        placed, mesh = scene.graph[body.name]
        np.testing.assert_allclose(
            (placed @ [0, 0, 0, 1])[:3], (turn @ [*frames.positions[0, number], 1])[:3], atol=1e-6
        )
        if isinstance(body.shape, st.Box):
            assert scene.geometry[mesh].is_watertight or len(scene.geometry[mesh].vertices) == 24
            np.testing.assert_allclose(scene.geometry[mesh].extents, body.shape.size, rtol=1e-6)


def test_a_file_without_bodies_or_motion_is_still_one(tmp_path: Path) -> None:
    calls: list[tuple[int, ...]] = []
    for bodies in (0, 1):
        world = st.World()
        if bodies:
            world.add(st.Box((1, 1, 1)), static=True)
        with world.record(tmp_path / "run.h5"):
            world.step(10)
        with st.Recording.open(tmp_path / "run.h5") as recording:
            write_glb(recording.frames(), tmp_path / "run.glb", lambda *told: calls.append(told))
        data = (tmp_path / "run.glb").read_bytes()
        magic, version, length, text = struct.unpack("<4sIII", data[:16])
        assert (magic, version, length) == (b"glTF", 2, len(data))
        told = json.loads(data[20 : 20 + text])
        assert "animations" not in told
        assert len(told["nodes"]) == 1 + bodies
        assert calls == [(1, 1)] * bodies


def test_what_cannot_be_written_is_refused_in_one_sentence(
    path: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with st.Recording.open(path) as recording:
        with pytest.raises(InvalidInputError, match=r"^path must end in \.glb, \.parquet, \.nc, got '.*run\.obj'\.$"):
            recording.export(tmp_path / "run.obj")
        (tmp_path / "file").write_text("")
        with pytest.raises(OutputError, match=r"^path must be a file that can be written"):
            recording.export(tmp_path / "file" / "run.glb")
        monkeypatch.setattr(export.importlib.util, "find_spec", lambda name: None)
        for form, package in ((".parquet", "pyarrow"), (".nc", "xarray")):
            with pytest.raises(InvalidInputError, match=rf'needs {package}: pip install "stiction\[data\]"\.$'):
                recording.export(tmp_path / f"run{form}")
