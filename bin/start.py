"""Starts the command line for bin/glassworkbench, in a plain Python or inside freecadcmd."""

import os
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

try:
    from glassworkbench.cli import main
except ModuleNotFoundError as error:
    print(
        f"glassworkbench: the Python {sys.version.split()[0]} lacks the module {error.name}; install it",
        file=sys.stderr,
    )
    os._exit(1)
except KeyboardInterrupt:
    print("glassworkbench: cancelled", file=sys.stderr)
    os._exit(1)

count = os.environ.get("GLASSWORKBENCH_ARGUMENTS")
if count is None:
    sys.exit(main(sys.argv[1:]))
sys.stdout = os.fdopen(3, "w", encoding="utf-8")
code = 1
try:
    code = main([os.environ[f"GLASSWORKBENCH_ARGUMENT_{number + 1}"] for number in range(int(count))])
finally:
    # freecadcmd would go on to its console, or exit with 0, after an error.
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(code)
