"""option_types.py PACKAGE_FOLDER: writes _option_types.pyi, the types of the options, from the built module's own list."""

import os
import sys

sys.dont_write_bytecode = True


def kind(entry):
    if "choices" in entry:
        return f"Literal[{', '.join(repr(choice) for choice in entry['choices'])}]"
    return {"amount": "int | str", "tuple": "tuple[int, int, int]"}.get(entry["type"], entry["type"])


def main(package):
    sys.path.insert(0, os.path.dirname(os.path.abspath(package)))
    from gpvc import _gpvc

    lines = ["# Made from the library's lists of options when the module was built.", "from typing import Literal, TypedDict"]
    for name, table in (("TextureOptions", _gpvc.texture_options()), ("VisibilityOptions", _gpvc.visibility_options())):
        lines += ["", f"class {name}(TypedDict, total=False):"]
        lines += [f"    {entry['name']}: {kind(entry)} | None" for entry in table]
    with open(os.path.join(package, "_option_types.pyi"), "w", encoding="utf-8") as file:
        file.write("\n".join(lines) + "\n")


main(sys.argv[1])
