// What the search prefers; a part of Sphinx's own script.

{
  // From a file a page may read no other one: then there are no excerpts.
  if (window.location.protocol === "file:")
    DOCUMENTATION_OPTIONS.SHOW_SEARCH_SUMMARY = false;

  const query = new URLSearchParams(window.location.search).get("q") || "";
  const words = query.toLowerCase().split(/\s+/).filter(Boolean);
  // Whoever searches wants a page to read: guides before reference.
  const places = { guides: 2, api: -3 };

  // Artefacts by their number come first (index), then pages whose title has the words.
  Scorer.score = ([docname, title, , , score, , kind]) => {
    if (kind === "index") return score;
    const named = words.filter((word) => title.toLowerCase().includes(word));
    const share = words.length ? named.length / words.length : 0;
    return score + 10 * share + (places[docname.split("/")[0]] ?? 0);
  };
}
