"""`python -m stlc`: the command, where its script is not on the path."""

from stlc.cli import main

main()
