"""Run the benchmarks, all or those named, one after the other: python bench/run.py [filter ...]."""

import subprocess
import sys
from pathlib import Path

import stickslip

HERE = Path(__file__).parent


def main() -> int:
    known = {path.stem.removeprefix("bench_"): path for path in sorted(HERE.glob("bench_*.py"))}
    names = sys.argv[1:] or list(known)
    if strangers := [name for name in names if name not in known]:
        print(f"bench: no benchmark {strangers[0]!r}; there are {', '.join(known)}", file=sys.stderr)
        return 2
    for key, value in stickslip.build_config().items():
        print(f"{key}: {value}")
    failed = []
    for name in names:
        print(f"\n== {name}", flush=True)
        if subprocess.run([sys.executable, str(known[name])], check=False).returncode:
            failed.append(name)
    print(
        f"\n{len(names) - len(failed)} benchmarks ran" + (f", failed: {', '.join(failed)}" if failed else "")
    )
    return int(bool(failed))


if __name__ == "__main__":
    sys.exit(main())
