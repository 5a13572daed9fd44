"""Model documents in YAML and JSON: read, and written to the last digit."""

from blockstruct.documents.reader import Document, read_document
from blockstruct.documents.writer import check_new_document, write_document, write_draft

__all__ = ["Document", "check_new_document", "read_document", "write_document", "write_draft"]
