"""The bundled millipede: body, codec, motion, fitness and presets."""
