"""The command line without its installed name: ``python -m cmtof``."""

from cmtof.cli import main

main()
