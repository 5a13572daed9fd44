"""Model documents in YAML and JSON: read, and written to the last digit."""

from blockstruct.documents.reader import Document, read_document
from blockstruct.documents.writer import write_document, write_draft

__all__ = ["Document", "read_document", "write_document", "write_draft"]
