"""Write the header that includes every header of a folder and lists the type that each defines.

`python cmake/type_lists.py FOLDER LIST NAMES OUT`: FOLDER/belt_seam.hpp defines `BeltSeam`; `LIST` is the type list of
them all in the order of their file names, `NAMES` the file names themselves.
"""

import sys
from pathlib import Path

HEADER = """// Written by cmake/type_lists.py from the files of {folder}/; not to be edited.
#pragma once

#include <array>
#include <string_view>

#include "stickslip/names.hpp"
{includes}

namespace stickslip::inline STICKSLIP_ISA {{

using {list} = TypeList<{types}>;
inline constexpr std::array<std::string_view, {count}> {names}{{{strings}}};

}}  // namespace stickslip::inline STICKSLIP_ISA
"""


def type_of(stem: str) -> str:
    """Return the type that a header defines: `belt_seam` has `BeltSeam`."""
    return "".join(part.capitalize() for part in stem.split("_"))


def header(folder: Path, type_list: str, names: str) -> str:
    """Return the text for all headers of a folder."""
    stems = sorted(path.stem for path in folder.glob("*.hpp"))
    return HEADER.format(
        folder=f"stickslip/{folder.name}",
        includes="\n".join(f'#include "stickslip/{folder.name}/{stem}.hpp"' for stem in stems),
        list=type_list,
        types=", ".join(map(type_of, stems)),
        count=len(stems),
        names=names,
        strings=", ".join(f'"{stem}"' for stem in stems),
    )


def main() -> int:
    """Write the header if it would change, so that nothing is compiled anew without need."""
    folder, type_list, names, out = sys.argv[1:]
    text, path = header(Path(folder), type_list, names), Path(out)
    if not path.exists() or path.read_text() != text:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    return 0


if __name__ == "__main__":
    sys.exit(main())
