"""JavaScript that simulates a fly in a web page, and the order of the scripts."""

SCRIPTS = ("flight.js", "control.js", "steering.js")
