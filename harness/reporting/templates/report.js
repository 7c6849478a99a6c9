// All but the first tables is in the page in compressed form, and is built when it is first visible: the page opens at
// once, however many problems it has.
(() => {
  const state = { built: 0, failed: 0, ready: false };
  window.gnomonCharts = state;
  const options = { actions: { export: true, source: false, compiled: false, editor: false } };
  const all = (selector, within = document) => [...within.querySelectorAll(selector)];
  const TWO_TICKS = 2.05; // decades
  const BESIDE = 28; // the most names of a legend beside a diagram; a longer legend is below it
  let data;

  async function unpacked(id) {
    const bytes = Uint8Array.from(atob(document.getElementById(id).textContent.trim()), (c) => c.charCodeAt(0));
    return new Response(new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"))).text();
  }

  // The switch "Hide in-house": remembered where the browser allows it.
  const root = document.documentElement;
  const without = () => "without" in root.dataset;
  const isOwn = (name) => String(name).startsWith(data.own);

  function remembered(value) {
    try {
      if (value !== undefined) localStorage.setItem("gnomon-without", value);
      return localStorage.getItem("gnomon-without") === "1";
    } catch {
      return value === "1"; // no storage for this page: the switch works until it is closed
    }
  }

  function setWithout(hidden) {
    root.toggleAttribute("data-without", hidden);
    document.getElementById("own").setAttribute("aria-pressed", String(hidden));
  }

  function toggleOwn() {
    setWithout(!without());
    remembered(without() ? "1" : "0");
    showCase(part("case").value);
    all(".chart").forEach((figure) => figure.dataset.state && figure.dataset.chart !== "work" && build(figure));
    drawMaps();
  }

  // Data are stored as columns, with each repeated word once.
  function rows(columns) {
    const names = Object.keys(columns);
    const values = names.map((name) => {
      const column = columns[name];
      return column.codes ? column.codes.map((code) => (code < 0 ? null : column.words[code])) : column;
    });
    return (values[0] || []).map((_, i) => Object.fromEntries(names.map((name, k) => [name, values[k][i]])));
  }

  // Positions in diagrams are stored as whole hundredths of a decade.
  function pointsOf(problem) {
    const points = rows(problem.points);
    for (const point of points) for (const name of ["time", "calls", "error"]) if (point[name] !== null) point[name] /= 100;
    return without() ? points.filter((point) => !isOwn(point.series)) : points;
  }

  function charted(packed) {
    const spec = structuredClone(packed);
    for (const name of Object.keys(spec.datasets)) spec.datasets[name] = rows(spec.datasets[name]);
    return spec;
  }

  // A scale of all integrators is reduced to those in colour on this problem, so that the legend has no others.
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

  // Layers without points (no failed trial, no grey line) have no extent, so the domains of the scales are set here.
  function span(spec, points, limits, axis) {
    const drawn = points.filter((point) => point[axis] !== null && point.error !== null);
    const across = drawn.map((point) => point[axis]);
    const down = [...drawn.map((point) => point.error), ...limits.map((limit) => limit.at)];
    const domains = { x: [0, 1], y: [Math.min(0, ...down) - 0.8, spec.datasets.margin[0].high] };
    if (across.length) {
      const [low, high] = [Math.min(...across), Math.max(...across)];
      const beside = Math.max(0.15, (TWO_TICKS - (high - low)) / 2); // at least two ticks on a logarithmic axis
      domains.x = [low - beside, high + beside];
    }
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
    const problem = data.work.cases[part("case").value][part("problem").value];
    const axis = pressed("axis");
    const spec = charted(data.work.specs[axis]);
    const points = pointsOf(problem);
    // If none is in colour, all failed, and the legend names these.
    if (pressed("which") === "all" || !points.some((point) => point.front && point[axis] !== null)) points.forEach((point) => (point.front = 1));
    spec.datasets.points = points;
    spec.datasets.limits = problem.limits;
    span(spec, points, problem.limits, axis);
    const named = new Set(points.filter((point) => point.front && point[axis] !== null).map((point) => point.series));
    restrict(spec.layer, named);
    spec.width = "container";
    spec.autosize = { type: "fit-x", contains: "padding" };
    if (figure.clientWidth < 700) {
      spec.height = 360;
      Object.assign(spec.config.legend, { orient: "bottom", columns: figure.clientWidth < 480 ? 1 : 2, labelLimit: 300 });
    } else if (named.size > BESIDE) {
      Object.assign(spec.config.legend, { orient: "bottom", columns: 4, labelLimit: 230 });
    }
    return spec;
  }

  function otherSpec(figure) {
    const name = figure.dataset.chart;
    const spec = charted(data.others[without() && `${name}_others` in data.others ? `${name}_others` : name]);
    if (without() && spec.datasets.spread) {
      spec.datasets.spread = spec.datasets.spread.filter((row) => !isOwn(row.integrator_id));
      spec.height = 24 * spec.datasets.spread.length;
    }
    if (typeof spec.width === "number") spec.width = "container";
    return spec;
  }

  async function build(figure) {
    figure.dataset.state = "building";
    try {
      const work = figure.dataset.chart === "work";
      const spec = work ? workSpec(figure) : otherSpec(figure);
      const result = await vegaEmbed(figure, spec, { ...options, renderer: "svg" });
      const svg = figure.querySelector("svg");
      svg.setAttribute("role", "img");
      svg.setAttribute("aria-label", figure.getAttribute("aria-label"));
      for (const name of ["role", "aria-roledescription", "aria-label"]) all(`[${name}]`, svg).forEach((mark) => mark.removeAttribute(name));
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

  // The maps: a row a case or problem, a column an integrator, three characters a cell (verdict, digits, digits short).
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

  function problemRow(map, [name, label, cells, why], shown, blue) {
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

  function byCaseOf(rows) {
    const found = new Map();
    rows.forEach((row) => found.set(row[0], [...(found.get(row[0]) ?? []), row]));
    return found;
  }

  const visible = (map) => map.series.map((_, i) => i).filter((i) => !(without() && isOwn(map.series[i])));

  function drawMaps() {
    const maps = { trust: trustMap, breaks: breakMap };
    all("[data-map]").forEach((place) => {
      place.replaceChildren();
      maps[place.dataset.map](place);
    });
  }

  function trustMap(place) {
    const map = data.map;
    const own = map.rows.filter((row) => row[1].startsWith("default"));
    const ran = (row, column) => row[2][3 * column] !== " " && !/^(un|not)/.test(map.verdicts[parseInt(row[2][3 * column], 16)]);
    const shown = visible(map).filter((i) => own.some((row) => ran(row, i)));
    const table = made("table");
    table.append(heading(map, shown));
    const byCase = byCaseOf(own);
    Object.entries(data.chapters).forEach(([chapter, names]) => {
      const rows = names.flatMap((name) => byCase.get(name) ?? []).map((given) => {
        const row = problemRow(map, given, shown, true);
        row.prepend(made("th", "", given[0] + given[1].slice("default".length)));
        return row;
      });
      if (!rows.length) return;
      const head = opener(made("tr", "chapter"), chapter, "", () => rows, true);
      head.append(Object.assign(made("td", "e"), { colSpan: shown.length }));
      table.append(head, ...rows);
    });
    place.append(table);
  }

  // A row whose heading shows and hides other rows; they are made when first shown, and hidden ones hide theirs.
  function opener(row, text, note, make, open = false) {
    const head = made("th");
    const button = made("button", "", `${text} `);
    if (note) button.append(made("small", "", note));
    head.append(button);
    row.prepend(head);
    row.below = open ? make() : [];
    row.set = (shown) => {
      button.setAttribute("aria-expanded", String(shown));
      if (shown && !row.below.length) row.after(...(row.below = make()));
      row.below.forEach((one) => {
        one.hidden = !shown;
        if (!shown) one.set?.(false);
      });
    };
    button.setAttribute("aria-expanded", String(open));
    button.addEventListener("click", () => row.set(button.getAttribute("aria-expanded") !== "true"));
    return row;
  }

  // One cell an integrator: on how many of the problems no setting was ok, and the most frequent status of those.
  function brokenRow(map, name, problems, shown) {
    const row = made("tr");
    shown.forEach((column) => {
      const all = problems.map((problem) => problem[2].slice(3 * column, 3 * column + 3)).filter((c) => c[0] !== " ")
        .map((c) => [map.verdicts[parseInt(c[0], 16)], c[1] === "-"]);
      const words = all.filter(([word]) => !/^(un|not)/.test(word));
      const missing = all.filter(([word]) => word === "not_run").length;
      if (!words.length) return row.append(made("td", "e", "·"));
      const counts = {};
      const broken = words.filter(([, lost]) => lost);
      broken.forEach(([word]) => (counts[word] = (counts[word] ?? 0) + 1));
      const most = Object.keys(counts).sort((a, b) => counts[b] - counts[a])[0];
      const ran = words.every(([word]) => word === "ok") ? "ok" : "partly";
      const kind = most ?? (missing ? "not_run" : ran);
      const failed = Object.entries(counts).map(([word, count]) => `${count} ${word}`).join(", ") || "none failed";
      const told = `of ${words.length} run ${failed}` + (missing ? `; ${missing} not run` : "");
      row.append(made("td", `s-${kind}`, broken.length || "", `${name}, ${map.series[column]}: ${told}`));
    });
    return row;
  }

  function breakMap(place) {
    const map = data.map;
    const shown = visible(map);
    const table = made("table");
    table.append(heading(map, shown));
    const many = (problems) => `${problems.length} problem${problems.length > 1 ? "s" : ""}`;
    const problemsOf = byCaseOf(map.rows);
    const caseRow = (name) => {
      const problems = problemsOf.get(name) ?? [];
      return opener(brokenRow(map, name, problems, shown), name, many(problems), () =>
        problems.map((given) => {
          const one = problemRow(map, given, shown, false);
          one.prepend(made("th", "variant", given[1]));
          return one;
        }),
      );
    };
    const few = problemsOf.size <= 20;
    Object.entries(data.chapters).forEach(([chapter, names]) => {
      const problems = names.flatMap((name) => problemsOf.get(name) ?? []);
      const row = opener(brokenRow(map, chapter, problems, shown), chapter, many(problems), () => names.map(caseRow), few);
      row.classList.add("chapter");
      table.append(row, ...row.below);
    });
    place.append(table);
  }

  // The table of cases: shows the cases that have all the words, and opens their chapters.
  function find(text) {
    const words = text.toLowerCase().replaceAll("_", " ").split(" ").filter(Boolean);
    all("details.chapter").forEach((chapter) => {
      const rows = all("tr[data-words]", chapter);
      rows.forEach((row) => (row.hidden = !words.every((word) => row.dataset.words.includes(word))));
      chapter.hidden = rows.every((row) => row.hidden);
      chapter.open = words.length > 0;
    });
    all('[data-role="found-none"]').forEach((text) => (text.hidden = all("details.chapter").some((chapter) => !chapter.hidden)));
  }

  // A click on a heading sorts by its column, a second one in the other direction; rows without a number are last.
  function sort(table, column, button) {
    const up = button.getAttribute("aria-sort") === "ascending" ? -1 : 1;
    all("thead button", table).forEach((one) => one.removeAttribute("aria-sort"));
    button.setAttribute("aria-sort", up > 0 ? "ascending" : "descending");
    const of = (row) => row.cells[column].dataset.value;
    const numbers = (a, b) => (of(a) === "") - (of(b) === "") || up * (Number(of(a)) - Number(of(b)));
    const told = (row) => row.cells[column].textContent;
    const words = (a, b) => up * told(a).localeCompare(told(b));
    const numeric = [...table.tBodies[0].rows].some((row) => of(row));
    table.tBodies[0].append(...[...table.tBodies[0].rows].sort(numeric ? numbers : words));
  }

  function showCase(name) {
    const problems = part("problem");
    const about = data.about[name];
    all('[data-role="case"]').forEach((select) => (select.value = name));
    part("title").textContent = about.title;
    part("section").textContent = `${name} · Beatty, Dynamics, section ${about.section}`;
    problems.replaceChildren(...Object.keys(about.stresses).map((label) => new Option(label, label)));
    all("[data-table]").forEach((place) => {
      const text = data.tables[name][(without() && place.dataset.others) || place.dataset.table];
      place.hidden = !text.trim();
      place.querySelector(".scroll").innerHTML = text;
    });
    part("permanent").href = `#case-${name}`;
    showProblem();
  }

  function showProblem() {
    const figure = panel.querySelector(".chart");
    const problem = part("problem").value;
    part("calls").hidden = pressed("axis") !== "calls";
    panel.querySelector(".stresses").textContent = data.about[part("case").value].stresses[problem] ?? "";
    const points = problem ? pointsOf(data.work.cases[part("case").value][problem]) : [];
    part("nothing").hidden = !points.length || points.some((point) => !point.failed);
    figure.hidden = !points.some((point) => point[pressed("axis")] !== null);
    if (figure.dataset.state && !figure.hidden) build(figure);
  }

  function listen() {
    all(".sortable").forEach((table) =>
      all("thead button", table).forEach((button, column) => button.addEventListener("click", () => sort(table, column, button))),
    );
    all('[data-role="find"]').forEach((field) => field.addEventListener("input", () => find(field.value)));
    document.addEventListener("change", (event) => {
      if (event.target.dataset.role === "case") showCase(event.target.value);
      if (event.target.dataset.role === "problem") showProblem();
    });
    all(".switch").forEach((buttons) =>
      buttons.addEventListener("click", (event) => {
        if (!event.target.value) return;
        all("button", buttons).forEach((one) => one.setAttribute("aria-pressed", String(one === event.target)));
        showProblem();
      }),
    );
    // On a narrow page legends are below the diagram: when the width passes that limit, it is built again.
    let narrow = window.innerWidth < 760;
    window.addEventListener("resize", () => {
      if (narrow === window.innerWidth < 760) return;
      narrow = !narrow;
      showProblem();
    });
    // A link to what is in a closed part opens it, one to a case shows its diagram.
    const opened = () => {
      const name = decodeURIComponent(location.hash.slice(1));
      const ofCase = name.startsWith("case-") && data.about[name.slice(5)];
      if (ofCase) showCase(name.slice(5));
      const target = name && document.getElementById(ofCase ? "work" : name);
      for (let part = target; part; part = part.parentElement) if (part.tagName === "DETAILS") part.open = true;
      if (target) target.scrollIntoView();
    };
    window.addEventListener("hashchange", opened);
    opened();
    // What scrolls can be reached by the keyboard.
    const sizes = new ResizeObserver((entries) => entries.forEach(({ target }) => {
      const scrolls = target.scrollWidth > target.clientWidth || target.scrollHeight > target.clientHeight;
      if (scrolls) target.tabIndex = 0;
      else target.removeAttribute("tabindex");
    }));
    all(".scroll").forEach((place) => sizes.observe(place));
    // A printed page has every chart.
    window.addEventListener("beforeprint", () => all(".chart").forEach((figure) => figure.dataset.state || build(figure)));
  }

  async function start() {
    data = JSON.parse(await unpacked("data"));
    const script = document.createElement("script");
    script.textContent = await unpacked("vega");
    document.head.append(script);
    const own = document.getElementById("own");
    if (own) {
      own.hidden = false;
      own.addEventListener("click", toggleOwn);
      setWithout(remembered());
    }
    showCase(data.first);
    drawMaps();
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
