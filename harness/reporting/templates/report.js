// The first pictures stand in the page as drawings. The others, and the tables of single cases, are in it in compressed
// form: the page opens at once, however many problems it has.
(() => {
  const state = { built: 0, failed: 0, ready: false };
  window.gnomonCharts = state;
  const root = document.documentElement;
  const all = (selector, within = document) => [...within.querySelectorAll(selector)];
  const byRole = (role) => document.querySelector(`[data-role="${role}"]`);
  const TWO_TICKS = 2.05; // decades
  const BESIDE = 22; // the most names of a legend beside a diagram; a longer legend is below it
  const MANY = 7000;
  let data;

  // Python's base85, 4 bytes in 5 characters, without the characters that have a meaning in HTML.
  function bytesOf(text) {
    const digits = new Uint8Array(128);
    [..."0123456789ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz!#$%:()*+-;,=.?@^_`{|}~"].forEach((c, i) => (digits[c.charCodeAt(0)] = i));
    const groups = Math.ceil(text.length / 5);
    const view = new DataView(new ArrayBuffer(4 * groups));
    for (let group = 0; group < groups; group++) {
      let number = 0;
      for (let k = 5 * group; k < 5 * group + 5; k++) number = 85 * number + (k < text.length ? digits[text.charCodeAt(k)] : 84);
      view.setUint32(4 * group, number);
    }
    return new Uint8Array(view.buffer, 0, text.length - groups);
  }

  const unpacked = (id) => new TextDecoder().decode(expand(bytesOf(document.getElementById(id).textContent.trim())));

  // LZMA as its author specifies it (lc = 3, lp = pb = 0), after the length in 4 bytes and a header of 13.
  function expand(bytes) {
    const out = new Uint8Array(new DataView(bytes.buffer).getUint32(0));
    const odds = (count) => new Uint16Array(count).fill(1024);
    let [at, place, range, code] = [0, 18, 0xffffffff, 0];
    const next = () => (code = ((code << 8) | bytes[place++]) >>> 0);
    for (let k = 0; k < 4; k++) next();
    const shift = () => {
      if (range >= 0x1000000) return;
      range = (range << 8) >>> 0;
      next();
    };
    function bit(of, k) {
      const bound = (range >>> 11) * of[k];
      const one = code >= bound ? 1 : 0;
      if (one) {
        range -= bound;
        code -= bound;
        of[k] -= of[k] >> 5;
      } else {
        range = bound;
        of[k] += (2048 - of[k]) >> 5;
      }
      shift();
      return one;
    }
    function tree(of, from, bits) {
      let found = 1;
      for (let k = 0; k < bits; k++) found = (found << 1) | bit(of, from + found);
      return found - (1 << bits);
    }
    function reversed(of, from, bits) {
      let [found, sum] = [1, 0];
      for (let k = 0; k < bits; k++) {
        const one = bit(of, from + found);
        found = (found << 1) | one;
        sum |= one << k;
      }
      return sum;
    }
    function direct(bits) {
      let found = 0;
      for (let k = 0; k < bits; k++) {
        range >>>= 1;
        const one = code >= range ? 1 : 0;
        if (one) code -= range;
        found = 2 * found + one;
        shift();
      }
      return found;
    }
    const lengths = () => ({ choice: odds(2), low: odds(8), middle: odds(8), high: odds(256) });
    const lengthOf = (of) =>
      !bit(of.choice, 0) ? tree(of.low, 0, 3) : !bit(of.choice, 1) ? 8 + tree(of.middle, 0, 3) : 16 + tree(of.high, 0, 8);
    const [isMatch, isAgain, isOther, isThird, isFourth, isLong] = Array.from({ length: 6 }, () => odds(12));
    const [literals, slots, near, align] = [odds(0x1800), odds(256), odds(128), odds(16)];
    const [matches, again] = [lengths(), lengths()];
    let [state, back] = [0, [0, 0, 0, 0]];
    while (at < out.length) {
      if (!bit(isMatch, state)) {
        const from = 0x300 * ((at ? out[at - 1] : 0) >> 5);
        let found = 1;
        if (state >= 7) {
          for (let like = out[at - back[0] - 1], same = true; same && found < 256; like <<= 1) {
            const wanted = (like >> 7) & 1;
            const one = bit(literals, from + ((1 + wanted) << 8) + found);
            found = (found << 1) | one;
            same = wanted === one;
          }
        }
        while (found < 256) found = (found << 1) | bit(literals, from + found);
        out[at++] = found;
        state = state < 4 ? 0 : state < 10 ? state - 3 : state - 6;
        continue;
      }
      let length;
      if (bit(isAgain, state)) {
        if (bit(isOther, state)) {
          const which = !bit(isThird, state) ? 1 : !bit(isFourth, state) ? 2 : 3;
          back.unshift(...back.splice(which, 1));
        } else if (!bit(isLong, state)) {
          state = state < 7 ? 9 : 11;
          out[at] = out[at - back[0] - 1];
          at++;
          continue;
        }
        length = lengthOf(again);
        state = state < 7 ? 8 : 11;
      } else {
        length = lengthOf(matches);
        state = state < 7 ? 7 : 10;
        const slot = tree(slots, 64 * Math.min(length, 3), 6);
        const bits = (slot >> 1) - 1;
        let far = slot < 4 ? slot : (2 | (slot & 1)) * 2 ** bits;
        if (slot >= 4) far += slot < 14 ? reversed(near, far - slot, bits) : 16 * direct(bits - 4) + reversed(align, 0, 4);
        back = [far, back[0], back[1], back[2]];
      }
      for (let end = Math.min(at + length + 2, out.length); at < end; at++) out[at] = out[at - back[0] - 1];
    }
    return out;
  }

  // The two switches; the label says what a press will do. Remembered where the browser allows it.
  const SWITCHES = {
    axis: { attribute: "data-calls", off: "Show evaluations", on: "Show time", changed: () => data && showProblem() },
    own: { attribute: "data-own", off: "Colour gnomon", on: "Grey gnomon", changed: () => {} },
  };

  function remembered(name, value) {
    try {
      if (value !== undefined) localStorage.setItem(`gnomon-${name}`, value);
      return localStorage.getItem(`gnomon-${name}`) === "1";
    } catch {
      return value === "1"; // no storage for this page: the switch works until it is closed
    }
  }

  function set(name, on) {
    const button = document.getElementById(name);
    if (!button) return;
    root.toggleAttribute(SWITCHES[name].attribute, on);
    button.hidden = false;
    button.setAttribute("aria-pressed", String(on));
    button.textContent = on ? SWITCHES[name].on : SWITCHES[name].off;
    SWITCHES[name].changed();
  }

  const axis = () => (root.hasAttribute("data-calls") ? "calls" : "time");

  // Data are stored as columns, with each repeated word once.
  function rows(columns) {
    const names = Object.keys(columns);
    const values = names.map((name) => {
      const column = columns[name];
      return column.codes ? column.codes.map((code) => (code < 0 ? null : column.words[code])) : column;
    });
    return (values[0] || []).map((_, i) => Object.fromEntries(names.map((name, k) => [name, values[k][i]])));
  }

  // Positions in diagrams are stored as whole hundredths of a decade, each less the one before.
  function pointsOf(problem) {
    const points = rows(problem.points);
    for (const name of ["time", "calls", "error"]) {
      let last = 0;
      for (const point of points) if (point[name] !== null) point[name] = (last += point[name]) / 100;
    }
    return points;
  }

  // HTML is stored as its markup, each once, and the texts between it as columns, with their numbers apart.
  function unfold(packed) {
    const reader = ({ forms, codes, numbers }) => {
      const [parts, values] = [forms.map((form) => form.split("\ue000")), numbers.split(" ")];
      let [k, n] = [0, 0];
      return () => parts[codes[k++]].reduce((text, part) => text + values[n++] + part);
    };
    const readers = packed.texts.map((columns) => columns.map(reader));
    let at = 0;
    return Object.fromEntries(packed.names.map((name, i) => {
      let html = "";
      for (const end = at + packed.counts[i]; at < end; at++) {
        const place = packed.order[at];
        html += packed.markup[place].reduce((text, part, slot) => text + readers[place][slot - 1]() + part);
      }
      return [name, html];
    }));
  }

  // HTML by name, unfolded when it is first asked for.
  function html(of, name, within = data) {
    if (within[of].markup) within[of] = unfold(within[of]);
    return within[of][name] ?? "";
  }

  // The table of kinds of systems, and the sentence on the first of a reader's libraries. All of it is in the data.
  function showKinds() {
    const choice = (role, first) => byRole(role)?.value ?? first;
    const [first] = Object.keys(data.kinds.orders);
    const [clock, group] = first.split("/");
    const key = [choice("clock", clock), choice("group", group), byRole("error").value].join("/");
    const place = `${key}/${byRole("kind").value}`;
    const mine = all('input[name="mine"]:checked').map((box) => box.value);
    const best = data.kinds.orders[place].find((name) => mine.includes(name));
    byRole("kinds").innerHTML = html("tables", key, data.kinds);
    byRole("answer").innerHTML = best === undefined ? data.kinds.nobody : html("said", `${place}/${best}`, data.kinds);
    byRole("shown-error").textContent = byRole("error").value;
    const code = byRole("answer").querySelector("pre");
    const lines = data.kinds.lines[code?.dataset.lines];
    if (lines) code.textContent = lines.replace("{method}", code.dataset.method).replace("{setting}", code.textContent);
  }

  // Parts of the page are drawn when a reader comes to them: scrolls near, opens, searches, follows a link, or prints.
  const sight = new IntersectionObserver((seen) => seen.forEach((one) => one.isIntersecting && arrive(one.target)), { rootMargin: "600px" });

  function arrive(target) {
    if (target.dataset.part) return draw(target);
    target.near = true;
    buildNext();
  }

  function draw(part) {
    if (!part.dataset.part) return;
    part.innerHTML = html("parts", part.dataset.part);
    delete part.dataset.part;
    sight.unobserve(part);
    if (window.innerWidth < 700) all("details.panel", part).forEach((fold) => (fold.open = false));
    if (state.all) buildNext();
  }

  const drawAll = (within) => all("[data-part]", within).forEach(draw);

  // The element with this id, drawn if it was not yet.
  function elementOf(id) {
    const words = `id="${id.replaceAll("&", "&amp;").replaceAll('"', "&#34;")}"`;
    const part = document.getElementById(id) ? null : all("[data-part]").find((one) => html("parts", one.dataset.part).includes(words));
    if (part) draw(part);
    return document.getElementById(id);
  }

  function charted(packed) {
    const spec = structuredClone(packed);
    for (const name of Object.keys(spec.datasets)) spec.datasets[name] = rows(spec.datasets[name]);
    spec.background = null;
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
  function span(spec, points, limits) {
    const drawn = points.filter((point) => point[axis()] !== null && point.error !== null);
    const across = drawn.map((point) => point[axis()]);
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

  const problemOf = () => data.work.cases[byRole("case").value][byRole("problem").value];

  function workSpec(figure) {
    const problem = problemOf();
    const spec = charted(data.work.specs[axis()]);
    const points = pointsOf(problem);
    // If none is in colour, all failed, and the legend names these.
    if (!points.some((point) => point.front && point[axis()] !== null)) points.forEach((point) => (point.front = 1));
    spec.datasets.points = points;
    spec.datasets.limits = problem.limits;
    span(spec, points, problem.limits);
    const named = new Set(points.filter((point) => point.front && point[axis()] !== null).map((point) => point.series));
    restrict(spec.layer, named);
    spec.width = "container";
    spec.autosize = { type: "fit-x", contains: "padding" };
    if (figure.clientWidth < 700) {
      spec.height = 340;
      Object.assign(spec.config.legend, { orient: "bottom", columns: 1, labelLimit: 300 });
    } else if (named.size > BESIDE) {
      Object.assign(spec.config.legend, { orient: "bottom", columns: 3, labelLimit: 230 });
    }
    return spec;
  }

  function otherSpec(figure) {
    const spec = charted(data.others[figure.dataset.chart]);
    if (typeof spec.width === "number") spec.width = "container";
    if (spec.width === "container") spec.autosize = { type: "fit-x", contains: "padding" };
    if (figure.clientWidth < 700) shorten(spec);
    if (spec.hconcat && figure.clientWidth < 700) stack(spec, figure.clientWidth);
    if (spec.facet && figure.clientWidth < 700) Object.assign(spec, { columns: 2 });
    return spec;
  }

  // On a narrow page names take at most two fifths of the width, and entries of a legend are below each other.
  function shorten(node) {
    if (!node || typeof node !== "object") return;
    if (node.labelLimit > 150) node.labelLimit = 150;
    if (node.legend?.orient === "top") node.legend.columns = 1;
    Object.values(node).forEach(shorten);
  }

  // Columns that stand beside each other on a wide page stand below each other on a narrow one, each with its names.
  function stack(spec, width) {
    spec.vconcat = spec.hconcat;
    delete spec.hconcat;
    for (const part of spec.vconcat) {
      part.width = Math.max(120, width - 190);
      for (const layer of part.layer) if (layer.encoding?.y?.axis) Object.assign(layer.encoding.y.axis, { labels: true, labelLimit: 150 });
    }
  }

  async function build(figure) {
    figure.dataset.state = "building";
    try {
      const spec = figure.dataset.chart === "work" ? workSpec(figure) : otherSpec(figure);
      const result = await vegaEmbed(figure, spec, { actions: false, renderer: "svg" });
      const svg = figure.querySelector("svg");
      svg.setAttribute("viewBox", svg.getAttribute("viewBox") ?? `0 0 ${svg.getAttribute("width")} ${svg.getAttribute("height")}`);
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

  // Figures are built one by one while the browser has nothing else to do, so that a printed or captured page has them;
  // once the page has MANY elements, those that a reader comes to.
  function buildNext() {
    const many = document.getElementsByTagName("*").length > MANY;
    const figure = all(".chart").find((one) => !one.dataset.state && (one.near || !many) && one.checkVisibility());
    if (!figure) return (state.all = true);
    const idle = window.requestIdleCallback ?? ((call) => setTimeout(call, 50));
    idle(async () => {
      if (!figure.dataset.state) await build(figure);
      buildNext();
    });
  }

  function find(text) {
    const words = text.toLowerCase().replaceAll("_", " ").split(" ").filter(Boolean);
    const chapters = all("details.chapter");
    chapters.forEach(drawAll);
    chapters.forEach((chapter) => {
      const found = all("tr[data-words]", chapter);
      found.forEach((row) => (row.hidden = !words.every((word) => row.dataset.words.includes(word))));
      chapter.hidden = found.every((row) => row.hidden);
      chapter.open = words.length > 0;
    });
    byRole("found-none").hidden = chapters.some((chapter) => !chapter.hidden);
  }

  function findCard(text) {
    const words = text.toLowerCase().split(" ").filter(Boolean);
    drawAll(document.getElementById("cards").parentElement);
    const cards = all(".method");
    cards.forEach((card) => (card.hidden = !words.length || !words.every((word) => card.dataset.words.includes(word))));
    const none = byRole("card-none");
    none.hidden = cards.some((card) => !card.hidden);
    none.textContent = words.length ? "No integrator has all these words." : "Type the name of an integrator.";
  }

  function showCase(name, problem) {
    const about = data.about[name];
    byRole("case").value = name;
    byRole("title").textContent = about.title;
    byRole("section").textContent = /^\d/.test(about.section) ? `${name} · Beatty, Dynamics, section ${about.section}` : name;
    const unrun = about.unrun.map((label) => Object.assign(new Option(`${label} (not run)`, label), { disabled: true }));
    byRole("problem").replaceChildren(...Object.keys(about.stresses).map((label) => new Option(label, label)), ...unrun);
    if (problem) byRole("problem").value = problem;
    byRole("permanent").href = `#case-${name}`;
    byRole("limit").textContent = about.limit;
    showProblem();
  }

  // All below the choice follows it: the diagram, the table, the stability.
  function showProblem() {
    const [name, problem] = [byRole("case").value, byRole("problem").value];
    const figure = document.querySelector('[data-chart="work"]');
    const points = problem ? pointsOf(problemOf()) : [];
    byRole("stresses").textContent = data.about[name].stresses[problem] ?? "";
    const unrun = data.about[name].lacking[problem] ?? "";
    byRole("unrun").hidden = !unrun;
    byRole("unrun").textContent = unrun;
    byRole("nothing").hidden = !points.length || points.some((point) => !point.failed);
    figure.hidden = !points.some((point) => point[axis()] !== null);
    const [third, own] = all("#work table.times");
    all("#work table.times tbody").forEach((body) => body.remove());
    third.insertAdjacentHTML("beforeend", html("times", `${name}/${problem}`));
    own.append(...all("tbody.own", third));
    for (const table of [third, own]) (table.closest("details") ?? table).hidden = !table.tBodies.length;
    const families = byRole("families");
    [...families.tBodies].forEach((body) => body.remove());
    families.insertAdjacentHTML("beforeend", html("families", `${name}/${problem}`));
    families.closest("details").hidden = !families.tBodies.length;
    byRole("limit").hidden = !problem.startsWith("default");
    byRole("stability").innerHTML = problem.startsWith("default") ? html("stability", name) : "";
    if (!figure.hidden) build(figure);
  }

  function download() {
    const map = data.map;
    const quoted = (text) => `"${String(text).replaceAll('"', '""')}"`;
    const lines = [["case", "problem", ...map.series].map(quoted).join(",")];
    map.rows.forEach(([name, problem, cells]) => lines.push([quoted(name), quoted(problem), ...cells.map((cell) => cell ?? "")].join(",")));
    const link = document.createElement("a");
    link.href = URL.createObjectURL(new Blob([lines.join("\n") + "\n"], { type: "text/csv" }));
    link.download = "gnomon_digits.csv";
    link.click();
    URL.revokeObjectURL(link.href);
  }

  function listen() {
    byRole("find")?.addEventListener("input", (event) => find(event.target.value));
    byRole("find-card")?.addEventListener("input", (event) => findCard(event.target.value));
    byRole("case").addEventListener("change", (event) => showCase(event.target.value));
    byRole("problem").addEventListener("change", showProblem);
    if (data.kinds) {
      byRole("choices").hidden = false;
      byRole("choices").addEventListener("change", showKinds);
      showKinds();
    }
    const button = byRole("download");
    button.hidden = false;
    button.addEventListener("click", download);
    // On a narrow page legends are below the diagram: when the width passes that limit, it is built again.
    let narrow = window.innerWidth < 700;
    window.addEventListener("resize", () => {
      if (narrow === window.innerWidth < 700) return;
      narrow = !narrow;
      showProblem();
    });
    // A link to what is in a closed part opens it, one to a case shows its diagram, one to a card shows the card.
    const opened = () => {
      const name = decodeURIComponent(location.hash.slice(1));
      const [, ofCase, problem] = name.match(/^case-([^/]+)\/?(.*)$/) ?? [];
      if (ofCase && data.about[ofCase]) showCase(ofCase, problem);
      const target = name && elementOf(ofCase ? "work" : name);
      for (let part = target; part; part = part.parentElement) {
        if (part.tagName === "DETAILS") part.open = true;
        if (part.classList.contains("method")) part.hidden = false;
      }
      if (target) target.scrollIntoView();
    };
    window.addEventListener("hashchange", opened);
    opened();
    all("[data-part], .chart").forEach((part) => sight.observe(part));
    const unfolded = ({ target }) => {
      if (!target.open) return;
      all("[data-part]", target).filter((part) => part.checkVisibility()).forEach(draw);
      buildNext();
    };
    document.addEventListener("toggle", unfolded, true);
    window.addEventListener("beforeprint", () => {
      drawAll(document);
      all("details").forEach((part) => (part.open = true));
      all(".chart").forEach(arrive);
    });
  }

  async function start() {
    if (window.innerWidth < 700) all("details.panel").forEach((part) => (part.open = false)); // before anything is read
    for (const name of Object.keys(SWITCHES)) {
      document.getElementById(name)?.addEventListener("click", () => {
        const on = !root.hasAttribute(SWITCHES[name].attribute);
        remembered(name, on ? "1" : "0");
        set(name, on);
      });
      set(name, remembered(name));
    }
    const pause = byRole("pause");
    if (pause) {
      pause.hidden = false;
      pause.addEventListener("click", () => {
        pause.textContent = pause.parentElement.classList.toggle("paused") ? "Move" : "Pause";
      });
    }
    await new Promise((drawn) => requestAnimationFrame(() => setTimeout(drawn)));
    data = JSON.parse(unpacked("data"));
    const script = document.createElement("script");
    script.textContent = unpacked("vega");
    document.head.append(script);
    listen();
    if (!byRole("problem").value) showCase(data.first);
    state.ready = true;
    buildNext();
  }

  start().catch((error) => {
    state.failed += 1;
    console.error(`the page's data: ${error}`);
  });
})();
