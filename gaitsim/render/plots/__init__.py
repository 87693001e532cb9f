"""Plots for papers and screens: one file for each kind, one style for all."""
