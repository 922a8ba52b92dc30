"""Real tosses of a cube: friction from motion that nobody made up. The data lie beside the repository, not in it."""

from __future__ import annotations

from pathlib import Path

import h5py
import numpy as np
import pytest

from stiction.fit import Problem, Track, fit, parse_all
from stiction.scene import Scene

DATA = Path(__file__).parents[3] / "shared" / "data" / "cube_tosses.h5"
EDGE, RATE = 0.1048, 148.0
NAMES = ("000", "002", "004", "006", "008", "010", "012", "014")
KEYS = "+".join(f"materials.pairs.cube-table.{name}" for name in ("static", "dynamic"))


@pytest.mark.skipif(not DATA.exists(), reason=f"the tosses are not at {DATA}")
def test_friction_of_real_tosses_comes_out_near_what_was_published() -> None:
    tracks, cubes = [], []
    with h5py.File(DATA) as file:
        for k, name in enumerate(NAMES):
            toss = np.array(file["toss"][name], dtype=np.float64)
            toss[:, 0] += 2.0 * k
            w, *u = toss[0, 3:7] / np.linalg.norm(toss[0, 3:7])
            spin, axis = toss[0, 10:13], np.array(u)  # in the body's axes
            turned = spin + 2.0 * w * np.cross(axis, spin) + 2.0 * np.cross(axis, np.cross(axis, spin))
            body = {"shape": {"type": "box", "size": [EDGE] * 3}, "mass": 0.37, "material": "cube"}
            pose = {"position": toss[0, :3].tolist(), "orientation": toss[0, 3:7].tolist()}
            moves = {"velocity": toss[0, 7:10].tolist(), "angular_velocity": turned.tolist()}
            cubes.append({"name": name, **body, **pose, **moves})
            turns = toss[:, 3:7] / np.linalg.norm(toss[:, 3:7], axis=1, keepdims=True)
            tracks.append(Track(name, np.arange(len(toss)) / RATE, toss[:, :3], turns))
    # cubes at rest are 0.0512 m high in the units of the data, so the table lies that much lower than half an edge says
    table = {"name": "table", "shape": {"type": "plane", "offset": -0.0012}, "static": True, "material": "table"}
    pair = {"a": "cube", "b": "table", "static": 0.3, "dynamic": 0.3, "restitution": 0.2}
    scene = Scene.from_dict(
        {
            "title": "Tosses",
            "expect": "Cubes land, bounce, slide and stop.",
            "duration": max(float(track.times[-1]) for track in tracks) + 1.0 / RATE,
            "world": {"dt": 0.5 / RATE},
            "materials": {"base": "empty", "pairs": [pair]},
            "bodies": [table, *cubes],
        }
    )
    problem = Problem(scene, tracks, parse_all([f"{KEYS}=0.05:0.5"], scene.table))
    # a cube that lands on an edge falls to either side, so the loss has many minima, of a toss or two above all
    made = fit(problem, starts=3, loss="soft_l1")
    (mu,) = made.estimates
    assert mu.seen and 0.12 < mu.value < 0.22, "0.18 was published"
    off = [
        np.linalg.norm(motion.positions - track.positions, axis=1).mean() / EDGE
        for motion, track in zip(problem.simulate(made.x), tracks, strict=True)
    ]
    assert np.mean(off) < 0.25
