"""`python -m tendond.daemon.cli`: the command line without its script."""

from tendond.daemon.cli.app import main

main()
