"""The parts of pages for a browser: scripts and styles, in the order in which a page needs them.

`three.min.js` is built by `npm run build` in `viewer_build/`; users build nothing.
"""

LIBRARY = "three.min.js"
"""The part of three.js that the viewer uses; defines `THREE`."""

VIEWER = (
    "unpack.js",
    "vectors.js",
    "recording.js",
    "lanes.js",
    "shading.js",
    "ribbons.js",
    "ground.js",
    "grid.js",
    "shadow.js",
    "orbit.js",
    "resolution.js",
    "readback.js",
    "stage.js",
    "rods.js",
    "facets.js",
    "solids.js",
    "marks.js",
    "body.js",
    "elements.js",
    "timeline.js",
    "controls.js",
    "panel.js",
    "player.js",
    "main.js",
)
"""The viewer: plain scripts that share one function's scope with the library."""

STYLES = ("viewer.css", "steering.css", "atlas.css")
"""Style sheets."""

BOOT = "boot.js"
"""Unpacks and runs a page's scripts; the only script of a page that is not packed."""
