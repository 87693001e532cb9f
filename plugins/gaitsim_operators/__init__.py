"""The bundled operators: selection, crossover, mutation."""
