"""How genomes change at random."""
