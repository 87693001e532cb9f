"""Pages for browsers: single files that make no network requests."""
