// What the pages are built of. Everything from the data enters as text, never as markup.
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
    const figure = (v) => {
        if (v === null || v === undefined || Number.isNaN(v)) return "–";
        if (typeof v !== "number") return String(v);
        if (v === 0) return "0";
        const size = Math.abs(v);
        return size >= 1e6 || size < 1e-4 ? v.toExponential(3) : String(Number(v.toPrecision(4)));
    };
    const part = (title) => make("h3", {}, title);
    const words = (sentences) => make("ul", {}, (sentences || []).map((s) => make("li", {}, s)));
    const table = (header, rows, leftColumns = []) => make("div", { className: "wide" },
        make("table", {}, make("thead", {}, make("tr", {}, header.map((h) => make("th", {}, h)))),
            make("tbody", {}, rows.map((row) => make("tr", {}, row.map((cell, c) =>
                make("td", { className: leftColumns.includes(c) ? "words" : "" }, figure(cell))))))));

    // What all charts have in common.
    const dressed = (layout) => ({
        font: { family: "system-ui, sans-serif", size: 12, color: "#1b1f24" },
        margin: { l: 64, r: 16, t: 40, b: 56 },
        height: 360, colorway: colours, hovermode: "closest",
        legend: { orientation: "h", y: -0.22 }, paper_bgcolor: "#fff", plot_bgcolor: "#fff",
        ...layout,
        ...(layout.title ? { title: { x: 0, xanchor: "left", ...layout.title } } : {}), // beside the buttons
    });
    const buttons = { displaylogo: false, responsive: true, showSendToCloud: false, plotlyServerURL: "",
        modeBarButtonsToRemove: ["sendDataToCloud", "select2d", "lasso2d"] };
    const pending = []; // plots wait until their place is in the document
    const chart = (name, traces, layout, caption) => {
        const place = make("div", { className: "chart" });
        place.dataset.chart = name;
        pending.push(() => Plotly.newPlot(place, traces, dressed(layout), buttons).catch(note));
        return make("figure", {}, place, caption ? make("figcaption", {}, caption) : null);
    };
    const axis = (title, more = {}) => ({ title: { text: title }, gridcolor: "#e6e9ec", zeroline: false, ...more });
    const scaleOf = (parameter) => (parameter && parameter.scale === "log" ? "log" : "linear");

    return { note, colours, symbols, dashes, make, figure, part, words, table, dressed, pending, chart, axis, scaleOf };
})();
