"""The bundled operators: selection, crossover and mutation."""
