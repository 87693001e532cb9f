"""The bundled millipede: body, codec, motion, fitness, ready experiments."""
