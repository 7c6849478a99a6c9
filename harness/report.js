// Everything beyond the first tables travels compressed, and is built when it is first seen: the page opens at once,
// however many scenes it holds.
(() => {
  const state = { built: 0, failed: 0, ready: false };
  window.gnomonCharts = state;
  const options = { actions: { export: true, source: false, compiled: false, editor: false } };
  const all = (selector, within = document) => [...within.querySelectorAll(selector)];
  let data;

  async function unpacked(id) {
    const bytes = Uint8Array.from(atob(document.getElementById(id).textContent.trim()), (c) => c.charCodeAt(0));
    return new Response(new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"))).text();
  }

  // Data travel as columns, repeated words once.
  function rows(columns) {
    const names = Object.keys(columns);
    const values = names.map((name) => {
      const column = columns[name];
      return column.codes ? column.codes.map((code) => (code < 0 ? null : column.words[code])) : column;
    });
    return (values[0] || []).map((_, i) => Object.fromEntries(names.map((name, k) => [name, values[k][i]])));
  }

  function charted(packed) {
    const spec = structuredClone(packed);
    for (const name of Object.keys(spec.datasets)) spec.datasets[name] = rows(spec.datasets[name]);
    return spec;
  }

  // A scale of all integrators is cut down to those that stand out in this scene, so that the legend has no strangers.
  function restrict(node, present) {
    if (!node || typeof node !== "object") return;
    const scale = node.scale;
    if (scale && node.field === "series" && Array.isArray(scale.domain)) {
      const kept = scale.domain.map((name, i) => [name, scale.range[i]]).filter(([name]) => present.has(name));
      scale.domain = kept.map((pair) => pair[0]);
      scale.range = kept.map((pair) => pair[1]);
    }
    Object.values(node).forEach((child) => restrict(child, present));
  }

  // Layers without a point of their own (no failed trial, no grey line) have no extent: the scales are given theirs.
  function span(spec, points, limits, axis) {
    const drawn = points.filter((point) => point[axis] !== null && point.error !== null);
    const across = drawn.map((point) => point[axis]);
    const down = [...drawn.map((point) => point.error), ...limits.map((limit) => limit.at)];
    const domains = { x: [0, 1], y: [Math.min(0, ...down) - 0.4, spec.datasets.margin[0].high] };
    if (across.length) domains.x = [Math.min(...across) - 0.15, Math.max(...across) + 0.15];
    for (const layer of spec.layer) {
      for (const channel of ["x", "y"]) {
        const encoding = layer.encoding?.[channel];
        if (encoding?.field) encoding.scale = { zero: false, nice: false, domain: domains[channel] };
      }
    }
  }

  const panel = document.getElementById("panel");
  const part = (role, within = panel) => within.querySelector(`[data-role="${role}"]`);
  const pressed = (role) => part(role).querySelector('[aria-pressed="true"]').value;

  function workSpec(figure) {
    const scene = data.work.cases[part("case").value][part("scene").value];
    const axis = pressed("axis");
    const spec = charted(data.work.specs[axis]);
    const points = rows(scene.points);
    if (pressed("which") === "all") points.forEach((point) => (point.front = 1));
    spec.datasets.points = points;
    spec.datasets.limits = scene.limits;
    span(spec, points, scene.limits, axis);
    restrict(spec.layer, new Set(points.filter((point) => point.front && point[axis] !== null).map((point) => point.series)));
    spec.width = "container";
    spec.autosize = { type: "fit-x", contains: "padding" };
    if (figure.clientWidth < 700) {
      spec.height = 360;
      Object.assign(spec.config.legend, { orient: "bottom", columns: figure.clientWidth < 480 ? 1 : 2, labelLimit: 300 });
    }
    return spec;
  }

  function otherSpec(figure) {
    const spec = charted(data.others[figure.dataset.chart]);
    if (typeof spec.width === "number") spec.width = "container";
    return spec;
  }

  async function build(figure) {
    figure.dataset.state = "building";
    try {
      const work = figure.dataset.chart === "work";
      const spec = work ? workSpec(figure) : otherSpec(figure);
      const result = await vegaEmbed(figure, spec, { ...options, renderer: "svg" });
      figure.view?.finalize();
      figure.view = result.view;
      figure.dataset.state = "built";
      state.built += 1;
    } catch (error) {
      figure.dataset.state = "failed";
      state.failed += 1;
      console.error(`chart ${figure.dataset.chart}: ${error}`);
    }
  }

  // The maps: a row a case or scene, a column an integrator, three characters a cell (verdict, digits, digits short).
  function made(tag, className, text = "", title = "") {
    const element = document.createElement(tag);
    if (className) element.className = className;
    if (text !== "") element.textContent = text;
    if (title) element.title = title;
    return element;
  }

  function heading(map, shown) {
    const row = made("tr");
    row.append(made("th"));
    shown.forEach((column) => {
      const cell = made("th", "", "", map.series[column]);
      cell.append(made("span", "", map.series[column]));
      row.append(cell);
    });
    return row;
  }

  function sceneRow(map, [name, label, cells, why], shown, blue) {
    const row = made("tr");
    shown.forEach((column) => {
      const [verdict, digits, lost] = cells.slice(3 * column, 3 * column + 3);
      if (verdict === " ") return row.append(made("td", "e"));
      const word = map.verdicts[parseInt(verdict, 16)];
      const short = parseInt(lost, 36);
      const text = digits === "-" ? map.letters[word] ?? "" : String(parseInt(digits, 36));
      const kind = digits !== "-" && blue ? `l${Math.min(8, short)}` : blue && /^(un|not)/.test(word) ? "e" : `s-${word}`;
      const told = digits === "-" ? `${word}: ${why[column] ?? ""}` : `${text} digits, ${short} short of the attainable`;
      row.append(made("td", kind, kind === "e" ? "" : text, `${name} ${label}, ${map.series[column]}: ${told}`));
    });
    return row;
  }

  function trustMap(place) {
    const map = data.map;
    const own = map.rows.filter((row) => row[1].startsWith("default"));
    const ran = (row, column) => row[2][3 * column] !== " " && !/^(un|not)/.test(map.verdicts[parseInt(row[2][3 * column], 16)]);
    const shown = map.series.map((_, i) => i).filter((i) => own.some((row) => ran(row, i)));
    const table = made("table");
    table.append(heading(map, shown));
    own.forEach((given) => {
      const row = sceneRow(map, given, shown, true);
      row.prepend(made("th", "", given[0] + given[1].slice("default".length)));
      table.append(row);
    });
    place.append(table);
  }

  function breakMap(place) {
    const map = data.map;
    const shown = map.series.map((_, i) => i);
    const table = made("table");
    table.append(heading(map, shown));
    const groups = new Map();
    map.rows.forEach((row) => groups.set(row[0], [...(groups.get(row[0]) ?? []), row]));
    groups.forEach((scenes, name) => {
      const row = made("tr");
      const head = made("th");
      const button = made("button", "", `${name} `);
      button.append(made("small", "", `${scenes.length} scene${scenes.length > 1 ? "s" : ""}`));
      button.setAttribute("aria-expanded", "false");
      head.append(button);
      row.append(head);
      shown.forEach((column) => {
        const words = scenes.map((scene) => scene[2].slice(3 * column, 3 * column + 3)).filter((c) => c[0] !== " ")
          .map((c) => [map.verdicts[parseInt(c[0], 16)], c[1] === "-"]).filter(([word]) => !/^(un|not)/.test(word));
        if (!words.length) return row.append(made("td", "e", "·"));
        const counts = {};
        const broken = words.filter(([, lost]) => lost);
        broken.forEach(([word]) => (counts[word] = (counts[word] ?? 0) + 1));
        const most = Object.keys(counts).sort((a, b) => counts[b] - counts[a])[0];
        const kind = most ?? (words.every(([word]) => word === "ok") ? "ok" : "partly");
        const told = Object.entries(counts).map(([word, count]) => `${count} ${word}`).join(", ") || "holds on all";
        row.append(made("td", `s-${kind}`, broken.length || "", `${name}, ${map.series[column]}: of ${words.length} scenes ${told}`));
      });
      table.append(row);
      button.addEventListener("click", () => {
        const open = button.getAttribute("aria-expanded") === "true";
        button.setAttribute("aria-expanded", String(!open));
        if (row.opened) return row.opened.forEach((one) => (one.hidden = open));
        row.opened = scenes.map((given) => {
          const one = sceneRow(map, given, shown, false);
          one.prepend(made("th", "variant", given[1]));
          return one;
        });
        row.after(...row.opened);
      });
    });
    place.append(table);
  }

  function showCase(name) {
    const scenes = part("scene");
    const about = data.about[name];
    all('[data-role="case"]').forEach((select) => (select.value = name));
    part("title").textContent = about.title;
    part("section").textContent = `${name} · Beatty, Dynamics, section ${about.section}`;
    scenes.replaceChildren(...Object.keys(about.stresses).map((label) => new Option(label, label)));
    all("[data-table]").forEach((place) => {
      const text = data.tables[name][place.dataset.table];
      place.hidden = !text.trim();
      place.querySelector(".scroll").innerHTML = text;
    });
    showScene();
  }

  function showScene() {
    const figure = panel.querySelector(".chart");
    const scene = part("scene").value;
    part("calls").hidden = pressed("axis") !== "calls";
    panel.querySelector(".stresses").textContent = data.about[part("case").value].stresses[scene] ?? "";
    figure.hidden = !scene;
    if (figure.dataset.state && scene) build(figure);
  }

  function listen() {
    document.addEventListener("change", (event) => {
      if (event.target.dataset.role === "case") showCase(event.target.value);
      if (event.target.dataset.role === "scene") showScene();
    });
    all(".switch").forEach((buttons) =>
      buttons.addEventListener("click", (event) => {
        if (!event.target.value) return;
        all("button", buttons).forEach((one) => one.setAttribute("aria-pressed", String(one === event.target)));
        showScene();
      }),
    );
    all("a[data-case]").forEach((link) => link.addEventListener("click", () => showCase(link.dataset.case)));
    // Legends move below the diagram on a narrow page, so a change of width past that point builds it anew.
    let narrow = window.innerWidth < 760;
    window.addEventListener("resize", () => {
      if (narrow === window.innerWidth < 760) return;
      narrow = !narrow;
      showScene();
    });
    // On paper every chart must be there.
    window.addEventListener("beforeprint", () => all(".chart").forEach((figure) => figure.dataset.state || build(figure)));
  }

  async function start() {
    data = JSON.parse(await unpacked("data"));
    const script = document.createElement("script");
    script.textContent = await unpacked("vega");
    document.head.append(script);
    showCase(Object.keys(data.work.cases)[0]);
    const maps = { trust: trustMap, breaks: breakMap };
    all("[data-map]").forEach((place) => maps[place.dataset.map](place));
    listen();
    const seen = new IntersectionObserver(
      (entries) => {
        for (const entry of entries) {
          if (!entry.isIntersecting || entry.target.hidden) continue;
          seen.unobserve(entry.target);
          build(entry.target);
        }
      },
      { rootMargin: "300px" },
    );
    all(".chart").forEach((figure) => seen.observe(figure));
    state.ready = true;
  }

  start().catch((error) => {
    state.failed += 1;
    console.error(`the page's data: ${error}`);
  });
})();
