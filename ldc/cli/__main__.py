"""`python -m ldc.cli`: the command where its script is not installed."""

from ldc.cli.start import entry

entry()
