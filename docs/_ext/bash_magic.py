"""``%%bash`` that prints what a script printed in one piece; loaded into the tutorials' kernels.

IPython's own sends pieces of 100 characters, which end up as lines broken in the middle.
"""

import subprocess
from typing import Any

from IPython import get_ipython


def bash(line: str, cell: str) -> None:
    """Run a cell with bash; raises if its last command fails."""
    done = subprocess.run(
        ["bash", "-c", cell], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
        check=False,
    )  # fmt: skip
    print(done.stdout, end="")
    done.check_returncode()


shell: Any = get_ipython()
if shell is not None:
    shell.register_magic_function(bash, "cell", "bash")
