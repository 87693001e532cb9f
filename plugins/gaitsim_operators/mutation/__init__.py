"""Mutation operators, which change genomes at random."""
