"""YAML as its version 1.2 reads it (core schema), for documents that may come from anywhere.

Version 1.1, which most libraries still follow, reads ``040`` as 32, ``1:30`` as 90 and ``no`` as False. A plain text
that the two versions read differently is refused with the remedy, and always written in quotes.
"""

import re
from collections import Counter
from collections.abc import Hashable
from typing import Any, NoReturn

import yaml

#: Levels of a document: a vertex of a block is on the sixth.
MOST_LEVELS = 40
#: Characters that aliases may add to a document: a few written ones could stand for more than any memory holds.
MOST_ADDED = 1_000_000

_TAG = "tag:yaml.org,2002:"
_SIXTY = r"[0-9][0-9_]*(?::[0-5]?[0-9])+(?:\.[0-9_]*)?"
#: Plain scalars that version 1.1 or 1.2 takes for a number or a truth value, and the other for something else.
_AMBIGUOUS = re.compile(
    rf"""(?: [-+]?0[0-9_]+ | 0o[0-7]+ | [-+]?0b[01_]+ | [-+]0x[0-9a-fA-F_]+ | [-+]?{_SIXTY}
    | (?=.*_) (?: [-+]?[0-9.][0-9_]*(?:\.[0-9_]*)?(?:[eE][-+]?[0-9]+)? | 0x[0-9a-fA-F_]+ )
    | yes|Yes|YES|no|No|NO|on|On|ON|off|Off|OFF | << )\Z""",
    re.VERBOSE,
)
_CORE = {
    "null": re.compile(r"(?:~|null|Null|NULL|)\Z"),
    "bool": re.compile(r"(?:true|True|TRUE|false|False|FALSE)\Z"),
    "int": re.compile(r"(?:[-+]?(?:0|[1-9][0-9]*)|0x[0-9a-fA-F]+)\Z"),
    "float": re.compile(r"(?:[-+]?(?:\.[0-9]+|[0-9]+(?:\.[0-9]*)?)(?:[eE][-+]?[0-9]+)?|[-+]?\.inf|\.nan)\Z", re.I),
}


def load(text: str) -> Any:
    """Content of a YAML document.

    Raises
    ------
    yaml.YAMLError, ValueError, RecursionError
        No YAML; a repeated key, or one that is no text; a text that YAML 1.1 and 1.2 read differently; a tag; more
        levels, or more that aliases stand for, than any model needs.
    """
    # A SafeLoader with fewer powers: it makes numbers, texts, lists and mappings.
    return yaml.load(text, Loader=_Loader)


def dump(content: Any) -> str:
    """Text of a document that :func:`load`, and any YAML 1.1 reader, reads back as it was."""
    # Collections without collections inside on one line: a vertex, a face, a vector.
    text: str = yaml.dump(
        content, Dumper=_Dumper, sort_keys=False, default_flow_style=None, width=120, allow_unicode=True
    )
    return text


class _Loader(yaml.SafeLoader):
    yaml_implicit_resolvers: dict[Any, Any] = {}  # noqa: RUF012 (a registry of PyYAML)

    def __init__(self, stream: str) -> None:
        super().__init__(stream)
        self._level = 0
        self._added = 0
        #: Characters of each node with all that its aliases stand for.
        self._sizes: dict[int, int] = {}

    def compose_node(self, parent: yaml.Node | None, index: Any) -> yaml.Node | None:
        event: Any = self.peek_event()  # type: ignore[no-untyped-call]
        if self._level > MOST_LEVELS:
            _refuse(f"nested more than {MOST_LEVELS} deep; no model needs that", event)
        if getattr(event, "tag", None) is not None:
            _refuse(f"the tag {event.tag!r}; leave tags out, and quote a text that looks like a number", event)
        if isinstance(event, yaml.ScalarEvent) and event.implicit[0] and _AMBIGUOUS.match(event.value):
            _refuse(f"{event.value} {_remedy(event.value)}", event)
        self._level += 1
        node = super().compose_node(parent, index)
        self._level -= 1
        if isinstance(event, yaml.AliasEvent):
            if id(node) not in self._sizes:
                _refuse(f"the alias *{event.anchor} stands for what it is part of; write it out", event)
            self._added += self._sizes[id(node)]
            if self._added > MOST_ADDED:
                _refuse(f"aliases stand for more than {MOST_ADDED:,} characters in all; write out what is meant", event)
        elif node is not None:
            self._sizes[id(node)] = 1 + self._content_size(node)
        return node

    def _content_size(self, node: yaml.Node) -> int:
        match node:
            case yaml.MappingNode(value=pairs):
                return sum(self._sizes[id(part)] for pair in pairs for part in pair)
            case yaml.SequenceNode(value=parts):
                return sum(self._sizes[id(part)] for part in parts)
        return len(node.value)

    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> dict[Hashable, Any]:
        keys = [self.construct_object(key) for key, _ in node.value]
        for key, (part, _) in zip(keys, node.value, strict=True):
            if not isinstance(key, str):
                _refuse("a key that is no text; quote it", part)
        twice = [key for key, count in Counter(keys).items() if count > 1]
        if twice:
            _refuse(f"repeated keys {twice[:10]}; rename or merge them", node)
        return super().construct_mapping(node, deep)

    def construct_yaml_int(self, node: yaml.ScalarNode) -> int:
        return int(node.value, 16 if node.value.startswith("0x") else 10)

    def construct_yaml_float(self, node: yaml.ScalarNode) -> float:
        # The resolver let no other words pass than .inf and .nan.
        return float(re.sub(r"\.(?=inf|nan)", "", node.value.lower()))


class _Dumper(getattr(yaml, "CSafeDumper", yaml.SafeDumper)):  # type: ignore[misc]
    """Quotes each text that YAML 1.1, YAML 1.2 or :func:`load` would take for anything else."""


for _name, _pattern in _CORE.items():
    _Loader.add_implicit_resolver(_TAG + _name, _pattern, None)
    _Dumper.add_implicit_resolver(_TAG + _name, _pattern, None)
_Dumper.add_implicit_resolver("!ambiguous", _AMBIGUOUS, None)
_Loader.add_constructor(_TAG + "int", _Loader.construct_yaml_int)
_Loader.add_constructor(_TAG + "float", _Loader.construct_yaml_float)


def _remedy(text: str) -> str:
    """What an ambiguous text can be read as, and what to write instead."""
    if text == "<<":
        return "merges keys in YAML 1.1 and is a text in YAML 1.2; write the keys out"
    if text.lower() in ("yes", "no", "on", "off"):
        truth = str(text.lower() in ("yes", "on")).lower()
        return f"is {truth} in YAML 1.1 and a text in YAML 1.2; write {truth}, or '{text}' in quotes for a text"
    return (
        "is read differently by YAML 1.1 and YAML 1.2; write a number without leading zeros, colons, underscores or "
        f"bases, or '{text}' in quotes for a text"
    )


def _refuse(what: str, place: Any) -> NoReturn:
    raise yaml.constructor.ConstructorError(None, None, what, place.start_mark)
