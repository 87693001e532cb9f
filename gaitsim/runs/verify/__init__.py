"""Verification: reproduce recorded generations and compare them with the files of the run."""
