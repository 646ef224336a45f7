"""`python -m ldc.cli`: the command where its script is not installed."""

from ldc.cli.main import entry

entry()
