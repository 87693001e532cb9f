"""A site of a folder of runs: an index with a card for each run, and a page that plays each."""
