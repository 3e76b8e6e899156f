"""mkdocs' hooks: reference pages from the code, links into the repository, formulas, nothing from the network."""

import posixpath
import re
from pathlib import Path

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.exceptions import PluginError
from mkdocs.structure.files import File, Files
from mkdocs.structure.pages import Page

from tendond.cli.manual.bus import keys_page, log_page, messages_page
from tendond.cli.manual.commands import commands_page
from tendond.cli.manual.configuration import configuration_page
from tendond.cli.manual.formulas import with_mathml
from tendond.cli.manual.links import ROOT_PAGES, SOURCE, source_page, with_links

GENERATED = {
    "reference/command-line.md": commands_page,
    "reference/configuration.md": configuration_page,
    "reference/keys.md": keys_page,
    "reference/log.md": log_page,
    "reference/messages.md": messages_page,
}
_ELSEWHERE = r"""["']?(?:https?:)?//"""
_LOADED = re.compile(
    rf"<(?:script|img|iframe|source)\b[^>]*\bsrc={_ELSEWHERE}"
    rf"|<link\b[^>]*\brel=\"(?!canonical)[^\"]*\"[^>]*\bhref={_ELSEWHERE}"
    rf"|url\(\s*{_ELSEWHERE}|@import\s+{_ELSEWHERE}"
    r"|class=\"mermaid\""  # whose script the theme would fetch
)


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add the generated pages, those of the repository's root, and whatever of the repository these name."""
    repository = Path(config.config_file_path).parent
    texts = {uri: (write(), "docs/" + posixpath.dirname(uri)) for uri, write in GENERATED.items()}
    texts |= {uri: ((repository / name).read_text(encoding="utf-8"), "") for name, uri in ROOT_PAGES.items()}
    for uri, (text, folder) in texts.items():
        if (stub := files.get_file_from_path(uri)) is not None:  # for those who read the repository itself
            files.remove(stub)
        files.append(File.generated(config, uri, content=with_links(text, repository, folder, uri, _ignore)))

    wanted = [(file.src_uri, file.content_string, "docs/" + posixpath.dirname(file.src_uri))
              for file in files.documentation_pages() if file.src_uri not in texts]  # fmt: skip
    wanted += [(uri, text, folder) for uri, (text, folder) in texts.items()]
    listed: set[str] = set()
    while wanted:
        page, text, folder = wanted.pop()
        named: list[str] = []
        with_links(text, repository, folder, page, named.append)
        for path in named:
            if path not in listed:
                listed.add(path)
                uri = f"{SOURCE}{path}.md"
                source, within = source_page(repository, path)
                files.append(File.generated(config, uri, content=with_links(source, repository, within, uri, _ignore)))
                if (repository / path).is_dir():
                    wanted.append((uri, source, within))
    return files


def on_page_markdown(markdown: str, page: Page, config: MkDocsConfig, files: Files) -> str:
    """Links of the pages that are files; the generated ones have theirs already."""
    if page.file.generated_by is not None:
        return markdown
    repository, uri = Path(config.config_file_path).parent, page.file.src_uri
    return with_links(markdown, repository, "docs/" + posixpath.dirname(uri), uri, _ignore)


def on_page_content(html: str, page: Page, config: MkDocsConfig, files: Files) -> str:
    """Write a page's formulas as MathML."""
    try:
        return with_mathml(html)
    except Exception as error:
        raise PluginError(f"{page.file.src_uri}: a formula cannot be read: {error!r}") from error


def on_post_build(config: MkDocsConfig) -> None:
    """Refuse a site that would load anything from the network."""
    for path in Path(config.site_dir).rglob("*"):
        if path.suffix in (".html", ".css") and (found := _LOADED.search(path.read_text(encoding="utf-8"))):
            raise PluginError(f"{path} loads from the network: {found[0][:120]}")


def _ignore(path: str) -> None:
    """Links are only turned, not followed."""
