"""Worlds and recordings in the cells of a notebook that a real kernel runs."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest

nbclient = pytest.importorskip("nbclient", reason="runs notebooks; it is no dependency of the tests")
nbformat = pytest.importorskip("nbformat", reason="makes notebooks; it is no dependency of the tests")
pytest.importorskip("ipykernel", reason="is the kernel of a notebook; it is no dependency of the tests")

CELLS = (
    """
import urllib.request
import stiction as st
world = st.World()
floor = world.add(st.Plane(), static=True)
ball = world.add(st.Sphere(0.5), position=(0, 0, 0.5), velocity=(1, 0, 0), name="ball")
viewer = world.show(port=0)
viewer
""",
    """
with world.record(PATH):
    world.run(0.2)
answer = urllib.request.urlopen(viewer.url).status
viewer.stop()
recording = st.Recording.open(PATH)
viewer = recording.show(port=0)
viewer
""",
    """
print(answer, urllib.request.urlopen(viewer.url).status)
viewer.stop()
""",
    "recording.inline(height=300)",
)


# what a kernel's own sockets and loops leave behind when it ends is not this package's
@pytest.mark.filterwarnings("ignore")
def test_a_world_and_a_recording_are_shown_in_cells(tmp_path: Path) -> None:
    notebook: Any = nbformat.v4.new_notebook()
    notebook.cells = [nbformat.v4.new_code_cell(cell.replace("PATH", repr(str(tmp_path / "run.h5")))) for cell in CELLS]
    nbclient.NotebookClient(notebook, timeout=120).execute()
    world, recording, answers, inline = (cell.outputs[0] for cell in notebook.cells)
    for output in (world, recording):
        assert re.match(r'<iframe src="http://127.0.0.1:\d+" width="100%"', output.data["text/html"])
    assert answers.text.split() == ["200", "200"]
    page = inline.data["text/html"]
    assert page.startswith('<iframe srcdoc="&lt;!doctype html&gt;')
    assert 'height="300"' in page[-200:]
    # the whole page lies within the quotes of the attribute
    assert page.count('"') == 8
