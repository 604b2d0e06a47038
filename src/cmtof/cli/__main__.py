"""``python -m cmtof.cli``."""

from cmtof.cli import main

main()
