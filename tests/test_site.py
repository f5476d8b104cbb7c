"""Claims about the site of `make site` in a real browser: it is searched, fits a phone, and asks no other server."""

from __future__ import annotations

import json
import queue
import subprocess
import sys
import threading
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer

import pytest

from places import ROOT
from test_report_browser import BROWSER, FLAGS

sys.path.insert(0, str(ROOT / "docs"))

pytest.importorskip("zensical", reason="zensical builds the site: pip install --group site")
pytest.importorskip(
    "latex2mathml", reason="latex2mathml writes the site's formulas: pip install --group site"
)

from generate import site

pytestmark = pytest.mark.slow
PHONE = 390
PAGES = [
    "",
    "notebooks/first-loop/",
    "explanation/the-plant/",
    "reference/python/",
    "reference/parameters/",
]
PAGES += ["how-to/export-to-c/", "contributing/", "contents/", "decisions/"]

# Opens pages in a frame as wide as a phone, then searches on the front page, and sends what it saw.
PROBE = """<!DOCTYPE html><iframe width="%d" height="844" style="border:0"></iframe><script>
const frame = document.querySelector("iframe"), seen = {pages: {}, asked: [], found: []};
const wait = (ready) => new Promise((done) => { const ask = () => ready() ? done() : setTimeout(ask, 50); ask(); });
const open = (page) => new Promise((done) => { frame.onload = done; frame.src = "/" + page; });
onload = async () => {
  for (const page of [...%s, ""]) {
    await open(page);
    await new Promise((done) => setTimeout(done, 300));
    const root = frame.contentDocument.documentElement;
    seen.pages[page] = [root.scrollWidth, root.clientWidth, root.querySelectorAll("article *").length];
    seen.asked.push(...frame.contentWindow.performance.getEntriesByType("resource").map((each) => each.name));
  }
  frame.contentDocument.querySelector(".md-search__button").click();
  let host;
  await wait(() => host = [...frame.contentDocument.body.children].find((e) => e.shadowRoot?.querySelector("input")));
  const field = host.shadowRoot.querySelector("input");
  field.value = "play operator";
  field.dispatchEvent(new Event("input", {bubbles: true}));
  await wait(() => host.shadowRoot.querySelector("li a"));
  seen.found = [...host.shadowRoot.querySelectorAll("li a")].map((each) => [each.getAttribute("href"), each.innerText]);
  fetch("/seen", {method: "POST", body: JSON.stringify(seen)});
};
</script>"""


@pytest.fixture(scope="module")
def built(tmp_path_factory):
    out = tmp_path_factory.mktemp("site") / "site"
    site.build(out)
    return out


@pytest.fixture(scope="module")
def seen(built, tmp_path_factory):
    """What the browser says of the site, served on this machine alone; every other name resolves to nothing."""
    if BROWSER is None:
        pytest.skip(
            "no Chromium or Chrome found: install one (apt-get install chromium) to open the site in it"
        )
    answers: queue.Queue[bytes] = queue.Queue()

    class Server(SimpleHTTPRequestHandler):
        def do_POST(self):
            answers.put(self.rfile.read(int(self.headers["content-length"])))
            self.send_response(204)
            self.end_headers()

        def log_message(self, *_):
            pass

    (built / "probe.html").write_text(PROBE % (PHONE, json.dumps(PAGES)), encoding="utf-8")
    with ThreadingHTTPServer(("127.0.0.1", 0), partial(Server, directory=str(built))) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        flags = [
            *FLAGS[:-1],
            "--host-resolver-rules=MAP * ~NOTFOUND, EXCLUDE 127.0.0.1",
            "--window-size=800,1000",
        ]
        profile = f"--user-data-dir={tmp_path_factory.mktemp('profile')}"
        page = f"http://127.0.0.1:{server.server_port}/probe.html"
        with subprocess.Popen(
            [BROWSER, *flags, profile, page], stderr=subprocess.DEVNULL
        ) as browser:
            try:
                return json.loads(answers.get(timeout=120)) | {
                    "here": page.removesuffix("probe.html")
                }
            finally:
                browser.terminate()
                server.shutdown()


def test_the_search_finds_the_play_operator(seen):
    first, text = seen["found"][0]
    assert "explanation/method/" in first and "play operator" in text


def test_no_page_is_wider_than_a_phone(seen):
    assert all(client == PHONE and elements > 10 for _, client, elements in seen["pages"].values())
    assert {page: scroll for page, (scroll, *_) in seen["pages"].items() if scroll > PHONE} == {}


def test_nothing_is_asked_of_another_server(seen):
    assert len(seen["asked"]) > 10
    assert [
        each for each in seen["asked"] if not each.startswith((seen["here"], "data:", "blob:"))
    ] == []


def test_every_page_notebook_and_formula_is_there(built):
    for source in (*ROOT.glob("docs/**/*.md"), *ROOT.glob("docs/**/*.ipynb")):
        page = (
            site.place(source.relative_to(ROOT).as_posix())
            .removesuffix(".md")
            .removesuffix("index")
        )
        assert (built / page.replace("decisions/README", "decisions") / "index.html").is_file(), (
            source
        )
    pages = "".join(page.read_text(encoding="utf-8") for page in built.rglob("*.html"))
    assert pages.count("<math") > 50 and "arithmatex" not in pages


def test_the_page_for_a_browser_is_part_of_the_site(built):
    part = "packages/dehyst-studio/src/dehyst_studio/html/dehyst.html"
    assert (built / part).read_bytes() == (ROOT / part).read_bytes()
    assert f'href="../../{part}"' in (built / "how-to/try-in-a-browser/index.html").read_text(
        encoding="utf-8"
    )


@pytest.mark.parametrize("link", ["nowhere.md", "explanation/method.md#nothing"])
def test_a_broken_link_fails(link, tmp_path, monkeypatch):
    page = site.page
    monkeypatch.setattr(
        site, "page", lambda source: page(source) + f"\n[x]({link})\n" * (source == "README.md")
    )
    with pytest.raises(subprocess.CalledProcessError):
        site.build(tmp_path / "site")
