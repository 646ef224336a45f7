"""Where the console script begins: nothing but the handling of Ctrl-C is loaded before the rest of ldc."""

from __future__ import annotations

import gc
import sys

from ldc.cli.interrupt import Unheeded


def entry() -> None:
    """Run the command of `sys.argv`, and end with its status."""
    with Unheeded():
        from ldc.cli.main import main
    status = main(sys.argv[1:])
    Unheeded().begin()  # for all that Python does at the end
    gc.freeze()  # nobody needs to look for what nobody uses
    sys.exit(status)
