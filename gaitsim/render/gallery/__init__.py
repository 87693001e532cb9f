"""Galleries: a site with an index of a folder of runs and a page that plays each run."""
