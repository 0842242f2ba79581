"use strict";
const all = (selector, within = document) => [...within.querySelectorAll(selector)];
const still = matchMedia("(prefers-reduced-motion: reduce)");

// ---- contents: the section that is being read ------------------------------------------------
const contents = new Map(all(".contents a").map(a => [a.hash.slice(1), a]));
if (matchMedia("(max-width: 61.9rem)").matches) all(".contents > details").forEach(d => d.open = false);
const reading = () => {
  const sections = all("main section[id]");
  const above = sections.filter(s => s.getBoundingClientRect().top < innerHeight / 3);
  const here = above.at(-1) ?? sections[0];
  for (const [id, a] of contents) {
    if (id === here.id) a.setAttribute("aria-current", "true"); else a.removeAttribute("aria-current");
  }
};
addEventListener("scroll", () => requestAnimationFrame(reading), { passive: true });
reading();

// ---- tables and claims that can be searched and filtered --------------------------------------
const filters = new Map();
for (const tools of all(".tools")) {
  const rows = all(tools.dataset.rows);
  const controls = all("select, input", tools);
  const count = tools.querySelector("[role=status]");
  const words = new Map(rows.map(row =>
    [row, `${row.textContent} ${row.dataset.words ?? ""}`.replace(/\s+/g, " ").toLowerCase()]));
  const show = () => {
    let shown = 0;
    for (const row of rows) {
      row.hidden = !controls.every(control => {
        if (control.type === "search")
          return words.get(row).includes(control.value.trim().toLowerCase());
        if (control.type === "checkbox") return !control.checked || row.hasAttribute(`data-${control.name}`);
        return !control.value || row.getAttribute(`data-${control.name}`) === control.value;
      });
      shown += !row.hidden;
    }
    for (const group of all(".group")) {
      if (rows.some(row => group.contains(row)))
        group.hidden = rows.every(row => row.hidden || !group.contains(row));
    }
    count.textContent = `${shown} of ${rows.length}`;
  };
  tools.addEventListener("input", show);
  tools.hidden = false;
  filters.set(tools.closest("section").id, { controls, show });
  show();
}

// ---- deep links: #EQ-14 opens the claim, #claims/verdict=refuted sets the filters ---------------
const follow = () => {
  const [id, wanted] = decodeURIComponent(location.hash.slice(1)).split("/");
  if (wanted !== undefined && filters.has(id)) {
    const { controls, show } = filters.get(id);
    const values = new URLSearchParams(wanted);
    for (const control of controls) {
      if (control.type === "checkbox") control.checked = values.has(control.name);
      else control.value = values.get(control.name) ?? "";
    }
    show();
  }
  const target = id && document.getElementById(id);
  if (!target) return;
  if (target.hidden) {
    const { controls, show } = filters.get(target.closest("section").id);
    for (const control of controls) {
      if (control.type === "checkbox") control.checked = false; else control.value = "";
    }
    show();
  }
  for (let at = target; at; at = at.parentElement) if (at.tagName === "DETAILS") at.open = true;
  target.scrollIntoView();
};
addEventListener("hashchange", follow);
if (location.hash) follow();

// ---- print: errata in full ----------------------------------------------------------------------
let opened = [];
addEventListener("beforeprint", () => {
  opened = all("details[data-print]:not([open])");
  opened.forEach(one => one.open = true);
});
addEventListener("afterprint", () => opened.forEach(one => one.open = false));
