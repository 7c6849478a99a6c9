// Builds each chart when it is first seen: the page opens at once, however many scenes it holds.
(() => {
  const charts = JSON.parse(document.getElementById("charts").textContent);
  const statusOf = { built: 0, failed: 0 };
  window.gnomonCharts = statusOf;
  const options = { actions: { export: true, source: false, compiled: false, editor: false } };

  // Data travel as columns, repeated words once.
  function rows(columns) {
    const names = Object.keys(columns);
    const values = names.map((name) => {
      const column = columns[name];
      return column.codes ? column.codes.map((code) => (code < 0 ? null : column.words[code])) : column;
    });
    return (values[0] || []).map((_, i) => Object.fromEntries(names.map((name, k) => [name, values[k][i]])));
  }

  function unpacked(packed) {
    const spec = structuredClone(packed);
    for (const name of Object.keys(spec.datasets)) spec.datasets[name] = rows(spec.datasets[name]);
    return spec;
  }

  // A scale of all integrators is cut down to those that this scene has, so that the legend has no strangers.
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

  function workSpec(figure) {
    const panel = figure.closest(".panel");
    const scene = charts.work.cases[figure.dataset.work][panel.querySelector("select").value];
    const axis = panel.querySelector('[data-axis][aria-pressed="true"]').dataset.axis;
    const spec = unpacked(charts.work.specs[axis]);
    const points = rows(scene.points);
    spec.datasets.points = points;
    spec.datasets.limits = scene.limits;
    restrict(spec.layer, new Set(points.filter((point) => point[axis] !== null).map((point) => point.series)));
    spec.width = "container";
    spec.autosize = { type: "fit-x", contains: "padding" };
    if (figure.clientWidth < 700) {
      spec.height = 360;
      Object.assign(spec.config.legend, { orient: "bottom", columns: figure.clientWidth < 480 ? 1 : 2, labelLimit: 260 });
    }
    return spec;
  }

  function otherSpec(figure) {
    const spec = unpacked(charts.others[figure.dataset.chart]);
    if (typeof spec.width === "number") spec.width = "container";
    return spec;
  }

  async function build(figure) {
    figure.dataset.state = "building";
    try {
      const spec = figure.dataset.work ? workSpec(figure) : otherSpec(figure);
      const result = await vegaEmbed(figure, spec, { ...options, renderer: figure.dataset.work ? "svg" : "canvas" });
      figure.view?.finalize();
      figure.view = result.view;
      figure.dataset.state = "built";
      statusOf.built += 1;
    } catch (error) {
      figure.dataset.state = "failed";
      statusOf.failed += 1;
      console.error(`chart ${figure.dataset.work || figure.dataset.chart}: ${error}`);
    }
  }

  const seen = new IntersectionObserver(
    (entries) => {
      for (const entry of entries) {
        if (!entry.isIntersecting) continue;
        seen.unobserve(entry.target);
        build(entry.target);
      }
    },
    { rootMargin: "300px" },
  );
  const figures = document.querySelectorAll(".chart");
  figures.forEach((figure) => seen.observe(figure));

  document.querySelectorAll(".chips").forEach((chips) => {
    chips.addEventListener("click", (event) => {
      const chosen = event.target.closest("button");
      if (!chosen) return;
      chips.querySelectorAll("button").forEach((button) => button.setAttribute("aria-selected", String(button === chosen)));
      document.querySelectorAll(`.panel[data-group="${chips.dataset.panels}"]`).forEach((panel) => {
        panel.hidden = panel.dataset.panel !== chosen.dataset.panel;
      });
    });
  });

  document.querySelectorAll('.panel[data-group="work"]').forEach((panel) => {
    const select = panel.querySelector("select");
    if (!select) return;
    const figure = panel.querySelector(".chart");
    select.addEventListener("change", () => {
      panel.querySelector(".stresses").textContent = select.selectedOptions[0].dataset.stresses;
      build(figure);
    });
    panel.querySelector(".switch").addEventListener("click", (event) => {
      const chosen = event.target.closest("button");
      if (!chosen) return;
      panel.querySelectorAll("[data-axis]").forEach((button) => button.setAttribute("aria-pressed", String(button === chosen)));
      panel.querySelector('[data-role="calls"]').hidden = chosen.dataset.axis !== "calls";
      build(figure);
    });
  });

  // Legends move below the diagram on a narrow page, so a change of width past that point builds it anew.
  let narrow = window.innerWidth < 760;
  window.addEventListener("resize", () => {
    if (narrow === window.innerWidth < 760) return;
    narrow = !narrow;
    figures.forEach((figure) => figure.dataset.work && figure.dataset.state === "built" && build(figure));
  });

  // On paper every panel shows, so every chart must be there.
  window.addEventListener("beforeprint", () => figures.forEach((figure) => figure.dataset.state || build(figure)));
})();
