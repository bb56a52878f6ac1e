"""What the command `lanewright` calls."""

import os

from ._lanewright import main


def run():
    """Run the command and end the process at once: there is nothing that the interpreter would have to clean up."""
    os._exit(main())
