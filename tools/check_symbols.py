"""Check that no function compiled for AVX can be merged into code that runs on every processor.

A template or inline function leaves a weak symbol in each object file that uses it, and the linker keeps
one copy of those that share a name. Were the AVX copy kept, an older processor would meet an
instruction it does not have. So every weak symbol in an AVX object must carry that instruction set's
namespace in its name: stickslip::avx2::..., stickslip::avx512::....
"""

import re
import subprocess
import sys
from pathlib import Path

BUILD = Path(__file__).parent.parent / "build" / "dev"
WIDE = ("avx2", "avx512")
WEAK = re.compile(r"^[0-9a-f]* ?([WVuwv]) (\S+)$")


def leaks(path: Path, isa: str) -> list[str]:
    """Return the mangled names of the defined weak symbols that do not name their instruction set."""
    listing = subprocess.run(
        ["nm", "--defined-only", "--no-sort", str(path)], check=True, capture_output=True, text=True
    ).stdout
    found = (WEAK.match(line) for line in listing.splitlines())
    return [m[2] for m in found if m and f"{len(isa)}{isa}" not in m[2]]


def main() -> int:
    """Check the object files of a build folder, build/dev unless one is given."""
    build = Path(sys.argv[1]) if len(sys.argv) > 1 else BUILD
    objects = [(isa, path) for isa in WIDE for path in sorted(build.glob(f"**/kernel_{isa}.dir/**/*.o"))]
    if not objects:
        print(f"{build}: no AVX objects to check; build the preset dev first")
        return 1
    bad = [(path, name) for isa, path in objects for name in leaks(path, isa)]
    for path, name in bad:
        plain = subprocess.run(["c++filt", name], capture_output=True, text=True, check=True).stdout.strip()
        print(f"{path.relative_to(build)}: weak symbol outside its namespace: {plain}")
    print(f"{len(objects)} AVX object files, {len(bad)} weak symbols that could be merged with baseline code")
    return int(bool(bad))


if __name__ == "__main__":
    sys.exit(main())
