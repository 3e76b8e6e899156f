"""`python -m tendond`: the command line without its script."""

from tendond.cli.app import main

main()
