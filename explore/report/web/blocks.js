// Building blocks of the pages. Everything from the data enters as text, never as markup.
"use strict";
const blocks = (() => {
    const failures = [];
    const note = (what) => {
        failures.push(String(what));
        document.documentElement.dataset.failures = failures.join("\n");
    };
    window.addEventListener("error", (e) => note(e.message));
    window.addEventListener("unhandledrejection", (e) => note(e.reason));
    document.addEventListener("securitypolicyviolation", (e) => note(e.violatedDirective + " " + e.blockedURI));

    // Colours of Okabe and Ito: told apart by colour-blind people; lines and marks differ in form as well.
    const colours = ["#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000", "#999933"];
    const symbols = ["circle", "square", "diamond", "triangle-up", "cross", "star", "x", "hexagon"];
    const dashes = ["solid", "dash", "dot", "dashdot", "longdash", "longdashdot"];

    // -- building blocks ------------------------------------------------------------------------------------------

    const make = (tag, properties = {}, ...children) => {
        const element = document.createElement(tag);
        Object.assign(element, properties);
        for (const child of children.flat(Infinity)) {
            if (child !== null && child !== undefined) element.append(child);
        }
        return element;
    };
    // Four significant digits, as the program prints them.
    const figure = (v) => {
        if (v === null || v === undefined || Number.isNaN(v)) return "–";
        if (typeof v !== "number") return String(v);
        if (v === 0) return "0";
        const digits = 3 - Math.floor(Math.log10(Math.abs(v)));
        return digits > 9 ? v.toExponential(3) : v.toFixed(Math.max(0, digits));
    };
    // Counts, places and round values: without zeros at the end.
    const plain = (v) => (typeof v === "number" ? String(Number(v.toPrecision(6))) : figure(v));
    const signed = (v, digits) => (v < 0 ? "-" : "+") + Math.abs(v).toFixed(digits);
    // "subgrade.modulus_MPa" in words over two lines, for what stands under or beside a chart.
    const broken = (name) => wording.titled(name).replace(" ", "<br>");
    // A heading of what follows it; open: not folded at first.
    const part = (title, open = false) => {
        const heading = make("h3", {}, title);
        heading.dataset.open = open ? "yes" : "";
        return heading;
    };
    // Content below a heading folds away under it.
    const folded = (children) => {
        const list = [];
        for (const child of children.flat(Infinity).filter((c) => c !== null && c !== undefined)) {
            if (child.tagName === "H3") {
                const details = make("details", { open: child.dataset.open === "yes" }, make("summary", {}, child));
                details.addEventListener("toggle", () => details.querySelectorAll(".js-plotly-plot").forEach((c) => Plotly.Plots.resize(c)));
                list.push(details);
            } else if (list.length && list[list.length - 1].tagName === "DETAILS") {
                list[list.length - 1].append(child);
            } else {
                list.push(child);
            }
        }
        return list;
    };
    const words = (sentences) => make("ul", {}, (sentences || []).map((s) => make("li", {}, s)));
    // A name may fold after its dots and underscores.
    const foldable = (text) => (/^[^ ]{9,}$/.test(text) ? text.split(/(?<=[._])/).flatMap((piece, i) => (i > 0 ? [make("wbr"), piece] : [piece])) : text);
    const table = (header, rows, leftColumns = []) => make("div", { className: "wide" },
        make("table", {}, make("thead", {}, make("tr", {}, header.map((h, c) => make("th", { className: leftColumns.includes(c) ? "words" : "" }, foldable(h))))),
            make("tbody", {}, rows.map((row) => make("tr", {}, row.map((cell, c) =>
                make("td", { className: leftColumns.includes(c) ? "words" : "" }, foldable(Number.isInteger(cell) ? plain(cell) : figure(cell)))))))));

    // The layout shared by all charts.
    const dressed = (layout) => ({
        font: { family: "system-ui, sans-serif", size: 12, color: "#1b1f24" },
        margin: { l: 64, r: 16, t: 40, b: 62 },
        height: 360, colorway: colours, hovermode: "closest",
        legend: { orientation: "h", y: -0.3 }, paper_bgcolor: "#fff", plot_bgcolor: "#fff",
        ...layout,
        ...(layout.title ? { title: { x: 0, xanchor: "left", ...layout.title } } : {}), // beside the buttons
    });
    const buttons = { displaylogo: false, responsive: true, showSendToCloud: false, plotlyServerURL: "",
        modeBarButtonsToRemove: ["sendDataToCloud", "select2d", "lasso2d"] };
    const pending = []; // plots wait until their place is in the document
    // onClick: what a click on a point does with its customdata.
    const chart = (name, traces, layout, caption, onClick) => {
        const place = make("div", { className: "chart" });
        place.dataset.chart = name;
        const named = traces.filter((t) => t.showlegend !== false && t.name && !["heatmap", "contour", "bar"].includes(t.type));
        const room = named.length > 1 ? { margin: { l: 64, r: 16, t: 40, b: 100 }, height: 400 } : {}; // for the legend
        pending.push(() => Plotly.newPlot(place, traces, dressed({ ...room, ...layout }), buttons)
            .then(() => onClick && place.on("plotly_click", (e) => onClick(e.points[0].customdata))).catch(note));
        return make("figure", {}, place, caption ? make("figcaption", {}, caption) : null);
    };
    const axis = (title, more = {}) => ({ title: { text: title }, gridcolor: "#e6e9ec", zeroline: false, ...more });
    const scaleOf = (parameter) => (parameter && parameter.scale === "log" ? "log" : "linear");
    // The axis of a parameter from low to high: logarithmic with every label in full, at 1, 2 and 5 where there is room.
    const scaled = (title, scale, low, high, more = {}) => {
        if (scale !== "log" || high < 3 * low) return axis(title, { range: [low, high], nticks: 5, ...more });
        const decades = Math.log10(high / low);
        return axis(title, { type: "log", range: [Math.log10(low), Math.log10(high)], tickformat: "~g", dtick: decades < 2.2 ? "D2" : Math.ceil(decades / 5), ...more });
    };
    // The same names as columns or rows: each in full over two lines.
    const named = (names, more = {}) => axis("", { automargin: true, tickvals: names, ticktext: names.map(broken), ...more });

    // A monotone cubic through three points or more that rise in x (Fritsch and Carlson 1980), at `wanted` or between them.
    const smooth = (x, y, wanted) => {
        if (x.length < 3) return { x, y };
        const d = x.slice(1).map((v, i) => (y[i + 1] - y[i]) / (v - x[i]));
        const n = x.length;
        // At an end: the parabola through three points, no steeper than keeps the curve monotone.
        const end = (h, next, slope, other) => {
            const m = ((2 * h + next) * slope - h * other) / (h + next);
            return m * slope <= 0 ? 0 : slope * other <= 0 && Math.abs(m) > 3 * Math.abs(slope) ? 3 * slope : m;
        };
        const m = x.map((_, i) => (i === 0 ? end(x[1] - x[0], x[2] - x[1], d[0], d[1]) : i === n - 1 ? end(x[n - 1] - x[n - 2], x[n - 2] - x[n - 3], d[n - 2], d[n - 3])
            : d[i - 1] * d[i] <= 0 ? 0 : 2 / (1 / d[i - 1] + 1 / d[i])));
        const places = wanted || x.slice(1).flatMap((v, i) => Array.from({ length: 12 }, (_, k) => x[i] + (v - x[i]) * k / 12)).concat(x[n - 1]);
        return { x: places, y: places.map((v) => {
            const i = Math.max(0, Math.min(n - 2, x.findIndex((w) => w > v) - 1));
            const h = x[i + 1] - x[i];
            const t = v >= x[n - 1] ? 1 : (v - x[i]) / h;
            const k = v >= x[n - 1] ? n - 2 : i;
            return (1 + 2 * t) * (1 - t) ** 2 * y[k] + t * (1 - t) ** 2 * h * m[k] + t * t * (3 - 2 * t) * y[k + 1] + t * t * (t - 1) * h * m[k + 1];
        }) };
    };

    return { note, colours, symbols, dashes, make, figure, plain, signed, broken, part, folded, words, table, dressed, pending, chart, axis, scaleOf, scaled, named, smooth };
})();
