"""JavaScript by which a web page flies a fly: the scripts in the order in which they run."""

SCRIPTS = ("flight.js", "control.js", "steering.js")
