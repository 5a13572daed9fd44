"""Model documents in YAML and JSON, read and written with all digits."""

from blockstruct.documents.document import (
    Document,
    check_new_document,
    document_of,
    read_content,
    read_document,
    write_document,
    write_draft,
)

__all__ = ["Document", "document_of", "read_content", "read_document"]
__all__ += ["check_new_document", "write_document", "write_draft"]
