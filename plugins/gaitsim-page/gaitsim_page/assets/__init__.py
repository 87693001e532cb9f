"""Scripts and style sheets of pages, in the order in which a page needs them.

`npm run build` in `viewer_build/` builds `three.min.js`, and `python -m gaitsim_page.kernels`
builds `spider.wasm`; users do not need to build anything.
"""

LIBRARY = "three.min.js"
"""The part of three.js that the viewer uses; it defines `THREE`."""

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
"""The scripts of the viewer, which run in the scope of one function."""

STYLES = ("viewer.css", "atlas.css", "playground.css")
"""Style sheets."""

BOOT = "boot.js"
"""The script that unpacks and runs the others, and the only one that is not packed."""
