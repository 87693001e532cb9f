"""The bundled reflexes, which change a gait by what the body feels."""
