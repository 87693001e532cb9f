"""The bundled searches."""
