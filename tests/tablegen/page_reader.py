"""Read an HTML page, and refuse what no page of this package may contain."""

import re
from html.parser import HTMLParser
from itertools import pairwise

VOID = {"meta", "br", "img", "input", "link", "hr"}


class Page(HTMLParser):
    """Tags with their attributes, and texts but those of scripts and styles."""

    def __init__(self, page):
        super().__init__()
        self.open, self.tags, self.texts = [], [], []
        self.feed(page)
        self.close()
        assert page.startswith("<!doctype html>")
        assert self.open == []

    def handle_starttag(self, tag, attrs):
        self.tags.append((tag, dict(attrs)))
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert [tag] == self.open[-1:]
        self.open.pop()

    def handle_data(self, data):
        if not {"script", "style"} & set(self.open):
            self.texts.append(data.strip())

    def values(self, name):
        return [attributes[name] for _, attributes in self.tags if name in attributes]


def read_page(text):
    """Check that a page is well-formed, with headings in order and links that work."""
    page = Page(text)
    names = [tag for tag, _ in page.tags]
    levels = [int(name[1]) for name in names if re.fullmatch("h[1-6]", name)]
    assert levels[0] == 1
    assert levels.count(1) == 1
    assert all(b <= a + 1 for a, b in pairwise(levels))
    identities = page.values("id")
    assert len(set(identities)) == len(identities)
    assert {link.removeprefix("#") for link in page.values("href")} <= set(identities)
    assert not {"link", "iframe", "object", "base"} & set(names)
    assert all(source.startswith("data:image/") for source in page.values("src"))
    for style in re.findall(r"<style>(.*?)</style>", text, re.DOTALL):
        assert not re.search(r"https?:|@import|url\(", style)
    return page
