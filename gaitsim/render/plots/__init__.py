"""Plots for papers and screens, in one style, with a module for each kind."""
