"""python -m lfdcore: the same as the command lfdcore."""

from lfdcore.cli.main import main

main()
