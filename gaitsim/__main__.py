"""`python -m gaitsim`."""

from gaitsim.cli import main

main()
