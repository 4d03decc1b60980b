"""Links of the Markdown pages lead to files and headings that exist, README leads to every page, and every picture is shown.  usage: links.py SOURCE_FOLDER"""
import pathlib
import re
import sys

source = pathlib.Path(sys.argv[1]).resolve()
pages = [source / name for name in ("README.md", "CONTRIBUTING.md", "CHANGELOG.md")] + sorted((source / "docs").rglob("*.md"))


def text_of(page):
    """Without code, which may hold what looks like a link."""
    return re.sub(r"```.*?```|`[^`\n]*`", "", page.read_text(), flags=re.S)


def anchors(page):
    """Headings as links name them; code in a heading counts."""
    titles = re.findall(r"^#+ (.*)$", re.sub(r"```.*?```", "", page.read_text(), flags=re.S), re.M)
    return {re.sub(r"[^\w -]", "", title.lower()).replace(" ", "-") for title in titles}


wrong, linked = [], {}
for page in pages:
    linked[page] = set()
    for link in re.findall(r"\]\(([^)\s]+)\)", text_of(page)):
        if link.startswith("http"):
            continue
        path, _, anchor = link.partition("#")
        target = (page.parent / path).resolve() if path else page
        if not target.exists() or anchor and anchor not in anchors(target):
            wrong.append(f"{page.relative_to(source)}: {link}")
        linked[page] |= set(target.glob("*.md")) if target.is_dir() else {target}
for picture in sorted((source / "docs/pictures").iterdir()):
    assert any(picture in targets for targets in linked.values()), f"no page shows {picture.name}"
    assert picture.stat().st_size < 90_000, f"{picture.name} is too large for the repository"
readme = source / "README.md"
missing = [page for page in pages if page != readme and page not in linked[readme]]
assert not wrong, "\n".join(wrong)
assert not missing, "README does not link " + ", ".join(str(page.relative_to(source)) for page in missing)
print(f"{len(pages)} pages, {sum(map(len, linked.values()))} links")
