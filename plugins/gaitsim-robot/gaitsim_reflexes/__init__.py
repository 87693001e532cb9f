"""The bundled reflexes, which change a gait by the measurements of sensors."""
