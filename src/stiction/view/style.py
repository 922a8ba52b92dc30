"""The look of stiction in one place: colours, line widths and sizes that the page and the plots share.

The five colours of motion stay apart under the common forms of colour blindness (protan, deutan and tritan): they
differ in lightness as well as in hue. Based on the palette of Okabe and Ito, "Color universal design", 2008.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stiction.motion import Motion

MOTION_COLORS: dict[Motion, str] = {
    Motion.FIXED: "#b9bfc5",
    Motion.FREE: "#74c4f2",
    Motion.STICKING: "#008f68",
    Motion.SLIDING: "#e8590c",
    Motion.ROLLING: "#6a3d9a",
}
"""Colour of a body by what it is doing."""

ASLEEP = "#52606d"
"""Colour of a body that sleeps, in the live view."""
INK = "#1f2a35"
"""Text, edges of bodies."""
MUTED_INK = "#5c6873"
"""Secondary text, axes."""
PAPER = "#ffffff"
"""Background of figures."""
SKY_TOP, SKY_BOTTOM = "#dfe8f1", "#fbfcfd"
"""Background of the page, from top to bottom."""
NORMAL = "#1230a8"
"""Normals of contacts."""
GROUND = "#e0e6eb"
"""Patches that stand for planes."""
GRID_LINE, GRID_SECTION = "#c3cbd3", "#98a4b0"
"""Lines of the grid on a plane: every cell, every fifth cell."""

FRICTION = "#c2185b"
"""Friction force in plots."""
SERIES = ("#0072b2", "#e8590c", "#008f68", "#6a3d9a", "#5c6873", "#c2185b", "#3fa7d6", "#8a6d00", "#1f2a35")
"""Colours of lines that stand for bodies, in their order: Okabe and Ito's, darker where they would be pale on white."""
EDGE_WIDTH = 0.014
"""Width of the dark edges of a body, as a share of its mean size."""
CONTACT_RADIUS = 0.065
"""Radius of a contact point, as a share of the typical size of the moving bodies."""
NORMAL_LENGTH = 0.75
"""Length of a contact normal, as a share of the typical size of the moving bodies."""

AMBIENT = 3.2
"""Light from all round that the page adds to the player's own, so that no face is dark."""
LAMP = 1.3
"""Light from the reader's side."""
LIGHT = 1.6
"""What a face in middling light sends back of it, were it white; measured in the page."""
OPACITY = 0.85
"""Of moving bodies: enough to see their contacts through them."""
NO_NOTE = "#webgl-software-rendering { display: none !important; }"
"""CSS against the player's note that there is no graphics card: it would lie over a scene that plays all the same."""
FONT_STACK = "system-ui, -apple-system, 'Segoe UI', Roboto, 'Helvetica Neue', Arial, sans-serif"
"""Fonts of the page: whatever the reader's system calls its own, so that nothing is fetched."""


def rgb(color: str) -> tuple[int, int, int]:
    """``#rrggbb`` as three numbers from 0 to 255."""
    return int(color[1:3], 16), int(color[3:5], 16), int(color[5:7], 16)


def surface(color: str) -> NDArray[np.uint8]:
    """Colour (3,) to give to viser's batched meshes, so that a face in middling light looks like ``color`` in the page.

    The player takes such a colour for the linear share of light sent back, lights it, and maps the result to the screen
    by the ACES film curve (S. Hill's fit, as three.js has it), which greys strong colours and burns out bright ones.
    Undone here: screen to light, light to surface.
    """
    screen = np.array(rgb(color)) / 255.0
    linear = np.where(screen > 0.04045, ((screen + 0.055) / 1.055) ** 2.4, screen / 12.92)
    y = np.clip(_ACES_OUT_INVERSE @ linear, 0.0, 0.99)
    # the curve y = (v^2 + 0.0245786 v - 0.000090537) / (0.983729 v^2 + 0.432951 v + 0.238081), solved for v
    a, b, c = 1.0 - 0.983729 * y, 0.0245786 - 0.432951 * y, -0.000090537 - 0.238081 * y
    v = (-b + np.sqrt(b * b - 4.0 * a * c)) / (2.0 * a)
    share = np.clip(0.6 * (_ACES_IN_INVERSE @ v) / LIGHT, 0.0, 1.0)
    result: NDArray[np.uint8] = np.round(255 * share).astype(np.uint8)
    return result


_ACES_IN_INVERSE = np.linalg.inv(
    [[0.59719, 0.35458, 0.04823], [0.07600, 0.90834, 0.01566], [0.02840, 0.13383, 0.83777]]
)
_ACES_OUT_INVERSE = np.linalg.inv(
    [[1.60475, -0.53108, -0.07367], [-0.10208, 1.10813, -0.00605], [-0.00327, -0.07276, 1.07602]]
)
