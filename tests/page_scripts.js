"use strict";
// Runs a script of the report on a page, without a browser: enough of a document for the
// scripts of the scoreboard and of all figures and tables, and no more. In: a page as a
// tree, the script, the address's hash and steps. Out: what is seen after each step.

class Node {
  constructor(tag, attributes = {}, kids = []) {
    this.tag = tag;
    this.attributes = new Map(Object.entries(attributes));
    this.listeners = {};
    this.kids = [];
    this.parentNode = null;
    for (const name of ["hidden", "open", "checked"]) {
      this[name] = this.attributes.has(name);
    }
    this.append(...kids.map((kid) => (typeof kid === "string" ? kid : grown(kid))));
  }

  get dataset() {
    const of = (name) => this.attributes.get("data-" + name);
    return new Proxy({}, { get: (_, name) => of(name) });
  }

  get childNodes() {
    return [...this.kids];
  }

  get textContent() {
    return this.kids.map((k) => (typeof k === "string" ? k : k.textContent)).join("");
  }

  set textContent(text) {
    this.kids = [text];
  }

  get options() {
    return this.querySelectorAll("option");
  }

  get value() {
    return this.said ?? this.attributes.get("value") ?? "";
  }

  // As in a browser, a choice that is not among the options is none.
  set value(text) {
    const known = this.tag !== "select" || this.options.some((o) => o.value === text);
    this.said = known ? text : "";
  }

  get elements() {
    const named = (name) => this.all().find((n) => n.attributes.get("name") === name);
    return new Proxy({}, { get: (_, name) => named(name) });
  }

  append(...kids) {
    for (const kid of kids) {
      if (kid instanceof Node) {
        if (kid.parentNode) {
          kid.parentNode.kids = kid.parentNode.kids.filter((other) => other !== kid);
        }
        kid.parentNode = this;
      }
      this.kids.push(kid);
    }
  }

  all() {
    const below = this.kids.filter((kid) => kid instanceof Node);
    return below.flatMap((kid) => [kid, ...kid.all()]);
  }

  matches(selector) {
    const parts = selector.match(/^[a-z]+|\.[\w-]+|:not\(\[[\w-]+\]\)|\[[\w-]+\]/g);
    if (parts.join("") !== selector) throw new Error("no such selector: " + selector);
    return parts.every((part) => {
      const inner = part.replace(/[^\w-]/g, "");
      if (part.startsWith(":not")) return !this[inner.slice(3)];
      if (part.startsWith("[")) return this.attributes.has(inner);
      const classes = (this.attributes.get("class") ?? "").split(" ");
      return part.startsWith(".") ? classes.includes(inner) : this.tag === part;
    });
  }

  querySelectorAll(selector) {
    return this.all().filter((node) => node.matches(selector));
  }

  querySelector(selector) {
    return this.querySelectorAll(selector)[0] ?? null;
  }

  closest(selector) {
    return this.matches(selector) ? this : this.parentNode?.closest?.(selector) ?? null;
  }

  setAttribute(name, text) {
    this.attributes.set(name, text);
  }

  addEventListener(type, told) {
    (this.listeners[type] ??= []).push(told);
  }

  happen(type) {
    for (const told of this.listeners[type] ?? []) told({ preventDefault() {} });
  }

  scrollIntoView() {}
}

function grown([tag, attributes, kids]) {
  return new Node(tag, attributes, kids);
}

function run({ tree, script, hash, steps }) {
  const page = grown(tree);
  const byId = (id) => page.all().find((n) => n.attributes.get("id") === id) ?? null;
  const window = new Node("window");
  const go = (address) => {
    const at = address.indexOf("#");
    window.location = { href: address, hash: at < 0 ? "" : address.slice(at) };
  };
  go("file:///page.html" + hash);
  window.history = { replaceState: (_, __, address) => go(address) };
  window.setTimeout = (then) => then();
  window.clearTimeout = () => {};
  const document = {
    getElementById: byId,
    querySelectorAll: (selector) => page.querySelectorAll(selector),
    createElement: (tag) => new Node(tag),
  };
  new Function("window", "document", script)(window, document);
  const seen = () => ({
    rows: page.querySelectorAll("tr[data-verdict]:not([hidden])")
      .map((row) => row.attributes.get("id")),
    shown: byId("rx-shown")?.textContent,
    sorted: Object.fromEntries(page.querySelectorAll("th[data-sort]")
      .map((head) => [head.dataset.sort, head.attributes.get("aria-sort")])),
    folds: ["details.rx-pending", "details.rx-more"]
      .flatMap((of) => page.querySelectorAll(of)).map((fold) => fold.open),
    forms: page.querySelectorAll("form").map((form) => form.hidden),
    hash: window.location.hash,
  });
  const found = [seen()];
  for (const step of steps) {
    if (step.click) {
      const heads = page.querySelectorAll("th[data-sort]");
      const head = heads.find((h) => h.dataset.sort === step.click);
      head.querySelector("button").happen("click");
    } else if (step.hash !== undefined) {
      go("file:///page.html" + step.hash);
      window.happen("hashchange");
    } else if (step.checked !== undefined) {
      const box = byId("rx-extensions").elements.shown;
      box.checked = step.checked;
      box.happen("change");
    } else {
      const form = byId("rx-filter");
      for (const [name, value] of Object.entries(step.fill)) {
        form.elements[name].value = value;
      }
      form.happen("input");
    }
    found.push(seen());
  }
  return found;
}

const chunks = [];
process.stdin.on("data", (chunk) => chunks.push(chunk));
process.stdin.on("end", () => {
  console.log(JSON.stringify(run(JSON.parse(Buffer.concat(chunks).toString("utf-8")))));
});
