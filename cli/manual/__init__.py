"""The reference pages of the documentation, written from the code; and what mkdocs needs beside its own."""
