"""`python -m tendond.cli`: the command line without its script."""

from tendond.cli.app import main

main()
