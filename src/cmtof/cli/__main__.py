"""The command line without its installed name: ``python -m cmtof.cli``."""

from cmtof.cli import main

main()
