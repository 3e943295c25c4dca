"""Prints the fields of every message of a package as ROS itself reads its definitions, from
the .idl files that its build has installed: JSON, type and name of each field by message.

    /usr/bin/python3 fields.py INSTALLED/share/PACKAGE
"""

import json
import sys
from pathlib import Path

from rosidl_parser.definition import (
    AbstractNestedType,
    AbstractString,
    BasicType,
    IdlLocator,
    Message,
    NamespacedType,
    UnboundedSequence,
)
from rosidl_parser.parser import parse_idl_file

# As they are written in .msg files.
BASIC = {"boolean": "bool", "double": "float64"}


def name_of(kind):
    if isinstance(kind, UnboundedSequence):
        return name_of(kind.value_type) + "[]"
    if isinstance(kind, AbstractNestedType):
        return f"{name_of(kind.value_type)}[{kind.size}]"
    if isinstance(kind, NamespacedType):
        return f"{kind.namespaces[0]}/{kind.name}"
    if isinstance(kind, AbstractString):
        return "string"
    assert isinstance(kind, BasicType), kind
    return BASIC.get(kind.typename, kind.typename)


def main():
    package, messages = Path(sys.argv[1]), {}
    for file in sorted(package.glob("msg/*.idl")):
        located = parse_idl_file(IdlLocator(package, file.relative_to(package)))
        for message in located.content.get_elements_of_type(Message):
            members = message.structure.members
            name = message.structure.namespaced_type.name
            messages[name] = [[name_of(member.type), member.name] for member in members]
    json.dump(messages, sys.stdout, indent=1)


main()
