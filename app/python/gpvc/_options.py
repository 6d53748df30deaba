"""Keyword arguments that are options: names, and what the help says of them."""

import difflib
import textwrap


def checked(function, options, table):
    """The options, all of which are in the table."""
    names = [entry["name"] for entry in table]
    for name in options:
        if name not in names:
            near = difflib.get_close_matches(name, names, 1)
            meant = f"; did you mean {near[0]!r}?" if near else ""
            raise TypeError(f"{function}() got an unexpected keyword argument {name!r}{meant}")
    return {name: value for name, value in options.items() if value is not None}


def _line(entry):
    name, kind = entry["name"], entry["type"]
    if "choices" in entry:
        values = ", ".join(repr(choice) for choice in entry["choices"])
    elif kind in ("int", "float") and entry["most"] > entry["least"]:
        values = f"{kind}, {entry['least']:g} to {entry['most']:g}"
    else:
        values = {"amount": "int of bytes, or str such as '4G'", "tuple": "three numbers of 0 to 255"}.get(kind, kind)
    text = entry["help"] + "." if entry["help"] else "The mode, as of the command line."
    if entry["default"] is True:
        text = "False: " + text[0].lower() + text[1:]
    return textwrap.fill(
        f"{name} ({values}; default {entry['default']!r}): {text}", 100, initial_indent="    ", subsequent_indent="        "
    )


def documented(table):
    """The options as a part of a docstring."""
    groups = {}
    for entry in table:
        groups.setdefault(entry["group"], []).append(_line(entry))
    return "\n\n".join(f"  {group}\n" + "\n".join(lines) for group, lines in groups.items())
