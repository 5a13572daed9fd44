"""Read and write YAML 1.2 (core schema) from untrusted sources.

Most libraries follow version 1.1, which reads ``040`` as 32, ``1:30`` as 90 and ``no`` as False. This module refuses a
plain text that the two versions read differently, and writes such a text in quotes.
"""

import re
from collections.abc import Iterator
from copy import deepcopy
from typing import Any, NoReturn

import yaml

from blockstruct.errors import shown
from blockstruct.files import MOST_READ

#: Remedy for a number with a decimal comma in a mapping on one line, where a comma ends a value.
_POINT = ", or write a number with a decimal point: 0.5 for 0,5"
_SIXTY = r"[0-9][0-9_]*(?::[0-5]?[0-9])+(?:\.[0-9_]*)?"
#: Plain scalars that one of the versions 1.1 and 1.2 reads as a number or a boolean, and the other does not.
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
    """Return the content of a YAML document: numbers, texts, booleans, lists, and mappings with text keys.

    Raises
    ------
    yaml.YAMLError, ValueError
        If the text is not YAML, a key is repeated or not a text, YAML 1.1 and 1.2 read a text differently, there is a
        tag, or the aliases exceed their limit.
    RecursionError
        If there are too many levels.
    """
    # libyaml, if available, is several times as fast.
    return _Reading(yaml.parse(text, Loader=getattr(yaml, "CSafeLoader", yaml.SafeLoader))).document()


def dump(content: Any) -> str:
    """Return the text of a content, which :func:`load` and any YAML 1.1 reader read back unchanged."""
    # Innermost collections are on one line: a vertex, a face, a vector.
    text: str = yaml.dump(
        content, Dumper=_Dumper, sort_keys=False, default_flow_style=None, width=120, allow_unicode=True
    )
    return text


class _Float(float):
    """Number whose repr is its text, for messages: a name written as 1.10 is not the block 1.1."""

    text: str

    def __repr__(self) -> str:
        return self.text

    __str__ = float.__repr__

    def __reduce__(self) -> tuple[type[float], tuple[float]]:
        # Copies are plain numbers.
        return float, (float(self),)


class _Reading:
    """Reader of a document, event by event. Each value has the number of its characters, with aliases written out."""

    def __init__(self, events: Iterator[Any]) -> None:
        self._events = events
        self._anchors: dict[str, tuple[Any, int] | None] = {}
        self._added = 0

    def document(self) -> Any:
        next(self._events)
        if isinstance(next(self._events), yaml.StreamEndEvent):
            return None
        value, _ = self._value(next(self._events))
        next(self._events)
        after = next(self._events)
        if not isinstance(after, yaml.StreamEndEvent):
            _refuse("a second document; keep one document per file", after)
        return value

    def _value(self, event: Any) -> tuple[Any, int]:
        if isinstance(event, yaml.AliasEvent):
            return self._alias(event)
        if event.tag is not None:
            _refuse(f"the tag {event.tag!r}; leave tags out, and quote a text that looks like a number", event)
        if event.anchor is not None:
            # None until the value of the anchor is known.
            self._anchors[event.anchor] = None
        value: tuple[Any, int]
        match event:
            case yaml.MappingStartEvent():
                value = self._mapping(event)
            case yaml.SequenceStartEvent():
                value = self._sequence()
            case _:
                value = _scalar(event), 1 + len(event.value)
        if event.anchor is not None:
            self._anchors[event.anchor] = value
        return value

    def _alias(self, event: Any) -> tuple[Any, int]:
        if event.anchor not in self._anchors:
            _refuse(f"the alias *{event.anchor} has no anchor before it", event)
        value = self._anchors[event.anchor]
        if value is None:
            _refuse(f"the alias *{event.anchor} contains itself; write it out", event)
        self._added += value[1]
        if self._added > MOST_READ:
            _refuse(f"aliases stand for more than {MOST_READ:,} characters in all; write the values out", event)
        # A copy, so that a change of one place of the document does not change the others.
        return deepcopy(value[0]), value[1]

    def _sequence(self) -> tuple[list[Any], int]:
        values, size = [], 1
        while not isinstance(event := next(self._events), yaml.SequenceEndEvent):
            value, more = self._value(event)
            values.append(value)
            size += more
        return values, size

    def _mapping(self, start: Any) -> tuple[dict[str, Any], int]:
        values: dict[str, Any] = {}
        twice, size = [], 1
        while not isinstance(event := next(self._events), yaml.MappingEndEvent):
            key, more = self._value(event)
            if not isinstance(key, str):
                comma = isinstance(key, int) and values and isinstance(next(reversed(values.values())), int)
                _refuse(f"a key that is not text; quote it{_POINT if comma else ''}", event)
            if key in values:
                twice.append(key)
            values[key], size_of_value = self._value(next(self._events))
            size += more + size_of_value
        if twice:
            _refuse(f"repeated keys {shown(sorted(set(twice)))}; rename or merge them", start)
        return values, size


def _scalar(event: Any) -> Any:
    text: str = event.value
    if not event.implicit[0]:
        return text
    if _AMBIGUOUS.match(text):
        _refuse(f"{text} {_remedy(text)}", event)
    kind = next((kind for kind, pattern in _CORE.items() if pattern.match(text)), "str")
    match kind:
        case "null":
            return None
        case "bool":
            return text.lower() == "true"
        case "int":
            return int(text, 16 if text.startswith("0x") else 10)
        case "float":
            # The only words in the pattern are .inf and .nan.
            number = _Float(re.sub(r"\.(?=inf|nan)", "", text.lower()))
            number.text = text
            return number
    return text


class _Dumper(getattr(yaml, "CSafeDumper", yaml.SafeDumper)):  # type: ignore[misc]
    """Writer that quotes each text that YAML 1.1, YAML 1.2 or :func:`load` would not read as a text."""


for _name, _pattern in _CORE.items():
    _Dumper.add_implicit_resolver(f"tag:yaml.org,2002:{_name}", _pattern, None)
_Dumper.add_implicit_resolver("!ambiguous", _AMBIGUOUS, None)


def _remedy(text: str) -> str:
    """Return the two readings of an ambiguous text and the remedy."""
    if text == "<<":
        return "merges keys in YAML 1.1 and is a text in YAML 1.2; write the keys out"
    if text.lower() in ("yes", "no", "on", "off"):
        truth = str(text.lower() in ("yes", "on")).lower()
        return f"is {truth} in YAML 1.1 and a text in YAML 1.2; write {truth}, or '{text}' in quotes for a text"
    return (
        "is read differently by YAML 1.1 and YAML 1.2; write a number without leading zeros, colons, underscores or "
        f"bases, or '{text}' in quotes for a text"
    )


def _refuse(problem: str, place: Any) -> NoReturn:
    raise yaml.constructor.ConstructorError(None, None, problem, place.start_mark)
