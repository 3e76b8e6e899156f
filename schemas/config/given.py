"""Whether a key was written or has its default: messages must not blame a key that nobody wrote."""

from pydantic import BaseModel


def by_default(section: BaseModel, *keys: str) -> str:
    """Return ' (by default)' where none of the keys of a section was given; else nothing."""
    return "" if section.model_fields_set & set(keys) else " (by default)"
