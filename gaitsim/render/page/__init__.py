"""Pages that play in a browser: one file each, which makes no request."""
