"""The logs of a folder: what each run was, tags and notes, an index, checksums."""
