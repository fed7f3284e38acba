"""What a page must give to everybody, asked of the page itself: contrast of what is written, focus, names."""

from __future__ import annotations

from typing import Any


CONTRAST = """() => {
  const rgba = (text) => { const [r, g, b, a = 1] = text.match(/[\\d.]+/g).map(Number); return [r, g, b, a]; };
  const over = (top, under) => [0, 1, 2].map((i) => top[3] * top[i] + (1 - top[3]) * under[i]);
  const linear = (v) => (v <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4);
  const light = (c) => [0.2126, 0.7152, 0.0722].reduce((sum, share, i) => sum + share * linear(c[i] / 255), 0);
  const ratio = (a, b) => {
    const [low, high] = [light(a), light(b)].sort((x, y) => x - y);
    return (high + 0.05) / (low + 0.05);
  };
  const ground = (item) => {
    const layers = [];
    for (let at = item; at; at = at.parentElement) layers.push(rgba(getComputedStyle(at).backgroundColor));
    return layers.reverse().reduce((under, top) => over(top, under), [255, 255, 255]);
  };
  const seen = (item) => item.checkVisibility({ visibilityProperty: true, opacityProperty: true })
    && !item.closest(".away, [inert]");
  const found = [];
  const told = (what, colour, under, needed) => {
    found.push({ what, ratio: ratio(over(rgba(colour), under), under), needed });
  };
  const walk = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  for (let node = walk.nextNode(); node; node = walk.nextNode()) {
    const item = node.parentElement;
    if (!node.data.trim() || !item || !seen(item) || ["SCRIPT", "STYLE", "OPTION"].includes(item.tagName)) continue;
    const style = getComputedStyle(item);
    const size = parseFloat(style.fontSize);
    const big = size >= 24 || (size >= 18.66 && Number(style.fontWeight) >= 700);
    const ink = item instanceof SVGElement ? style.fill : style.color;
    told(node.data.trim().slice(0, 40), ink, ground(item), big ? 3 : 4.5);
  }
  for (const item of document.querySelectorAll("button, select, input[type=search]")) {
    if (!seen(item) || item.closest(".evidence")) continue;
    const name = `edge of ${item.tagName} ${item.textContent.slice(0, 20)}`;
    told(name, getComputedStyle(item).borderTopColor, ground(item.parentElement), 3);
  }
  return found;
}"""

REACHABLE = """() => [...document.querySelectorAll("a[href], button, select, input, summary, [tabindex]")]
  .filter((item) => item.tabIndex >= 0 && !item.disabled && item.checkVisibility({ visibilityProperty: true }))
  .map((item, k) => { item.dataset.reach = String(k); return item.tagName; })"""

FOCUSED = """() => {
  const item = document.activeElement;
  const style = getComputedStyle(item);
  return [item.dataset.reach ?? null, style.outlineStyle !== "none" && parseFloat(style.outlineWidth) >= 1];
}"""


def pale(page: Any) -> list[str]:
    """Return what is written, or drawn around a control, with less contrast than WCAG 2 asks for at level AA."""
    found = page.evaluate(CONTRAST)
    assert len(found) > 10
    return [f"{item['what']}: {item['ratio']:.2f}" for item in found if item["ratio"] < item["needed"]]


def tabbed(page: Any) -> tuple[set[str], set[str], list[str]]:
    """Return what should be reached by the tabulator, what is, and what showed no focus."""
    wanted = {str(k) for k in range(len(page.evaluate(REACHABLE)))}
    page.evaluate("() => { document.activeElement.blur(); window.scrollTo(0, 0); }")
    reached: set[str] = set()
    blind = []
    for _ in range(len(wanted) + 3):
        page.keyboard.press("Tab")
        number, shown = page.evaluate(FOCUSED)
        if number is not None:
            reached.add(number)
            if not shown:
                blind.append(number)
    return wanted, reached, blind


def nameless(page: Any) -> list[str]:
    """Return the roles of controls, tables, pictures and regions that a screen reader has no name for."""
    client = page.context.new_cdp_session(page)
    nodes = client.send("Accessibility.getFullAXTree")["nodes"]
    roles = {"button", "slider", "combobox", "checkbox", "searchbox", "textbox", "link", "table", "image", "img",
             "application", "region", "group", "radio"}  # fmt: skip
    found = []
    for node in nodes:
        role = node.get("role", {}).get("value", "")
        if not node.get("ignored") and role in roles and not node.get("name", {}).get("value", "").strip():
            found.append(role)
    return found


def complaints(page: Any) -> list[str]:
    """Return what keeps somebody from the page: out of the tabulator's reach, unseen focus, no name, pale on screen or
    paper.
    """
    wanted, reached, blind = tabbed(page)
    found = [f"not reached by the tabulator: {_told(page, number)}" for number in sorted(wanted - reached)]
    found += [f"focus is not seen: {_told(page, number)}" for number in blind]
    found += [f"no name: {role}" for role in nameless(page)]
    found += [f"pale: {words}" for words in pale(page)]
    page.emulate_media(media="print")
    found += [f"pale on paper: {words}" for words in pale(page)]
    page.emulate_media(media="screen")
    return found


def _told(page: Any, number: str) -> str:
    return str(page.evaluate("(k) => document.querySelector(`[data-reach='${k}']`).outerHTML.slice(0, 120)", number))
