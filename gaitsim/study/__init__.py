"""Sweeps: many experiments that differ along axes, each repeated, in one table."""
