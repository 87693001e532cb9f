"""The bundled millipede: body, codec, motion, fitness, presets."""
