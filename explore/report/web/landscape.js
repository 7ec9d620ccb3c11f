// The landscape of the misfit of `unique`: a corner of pairs and profiles, and one pair large.
"use strict";
const landscapes = (() => {
    const { colours, make, figure, plain, broken, part, pending, chart, axis, scaled, smooth } = blocks;

    const parameterAxis = (p, [low, high] = [p.min, p.max], title = wording.titled(p.name)) => scaled(title, p.scale, low, high, { automargin: true });
    const minimumMark = { symbol: "circle", size: 9, color: "#fff", line: { color: "#000", width: 2 } };
    const minimaTrace = (minima, x, y) => ({
        type: "scatter", mode: (minima || []).length > 1 ? "markers+text" : "markers", showlegend: false, name: "minima",
        x: (minima || []).map((m) => m.parameters[x.name]), y: (minima || []).map((m) => (y ? m.parameters[y.name] : 0)),
        text: (minima || []).map((_, i) => String(i + 1)), textposition: "top right", textfont: { color: "#000" }, marker: minimumMark,
    });

    const unitOf = (p, v) => (p.scale === "log" ? Math.log(v / p.min) / Math.log(p.max / p.min) : (v - p.min) / (p.max - p.min));
    const valueAt = (p, u) => (p.scale === "log" ? p.min * (p.max / p.min) ** u : p.min + u * (p.max - p.min));
    // Around what the data accept of a parameter: its range and three quarters of that on either side, within the box.
    const around = (p, profile) => {
        const [low, high] = profile ? [unitOf(p, profile.low), unitOf(p, profile.high)] : [0, 1];
        const margin = 0.75 * Math.max(high - low, 0.01);
        return [valueAt(p, Math.max(0, low - margin)), valueAt(p, Math.min(1, high + margin))];
    };
    // A monotone cubic through known values, a straight line where one beside is not known.
    const between = (x, y, wanted) => {
        const cubic = smooth(x, y, wanted).y;
        return wanted.map((v, k) => {
            if (Number.isFinite(cubic[k])) return cubic[k];
            const i = Math.max(0, Math.min(x.length - 2, x.findIndex((w) => w > v) - 1));
            return y[i] + (y[i + 1] - y[i]) * (v - x[i]) / (x[i + 1] - x[i]);
        });
    };
    // The rises of a pair over a fine even grid, by way of their roots, which are nearly linear beside a minimum.
    const refined = (pair, px, py, wx, wy) => {
        const even = (p, [low, high]) => Array.from({ length: 61 }, (_, i) => unitOf(p, low) + (unitOf(p, high) - unitOf(p, low)) * i / 60);
        const [ux, uy] = [even(px, wx), even(py, wy)];
        const root = pair.rise.map((row) => row.map((v) => (v === null ? NaN : Math.sqrt(Math.max(0, v)))));
        const [x, y] = [pair.x_values.map((v) => unitOf(px, v)), pair.y_values.map((v) => unitOf(py, v))];
        const rows = root.map((row) => between(x, row, ux));
        const columns = ux.map((_, i) => between(y, rows.map((row) => row[i]), uy));
        return { x: ux.map((u) => valueAt(px, u)), y: uy.map((u) => valueAt(py, u)),
            rise: uy.map((_, j) => ux.map((__, i) => (Number.isFinite(columns[i][j]) ? columns[i][j] ** 2 : null))) };
    };
    // The valley that was followed, from one end through the best minimum to the other.
    const valleyOf = (unique) => {
        const traces = (unique.traces || []).filter((t) => t.accepted_end);
        const best = (unique.minima[0] || {}).parameters;
        const points = traces.map((t) => [...t.points.filter((q) => q.rise <= unique.landscape.limit).map((q) => q.parameters), t.accepted_end]);
        return points.length === 0 ? null : { way: [...[...points[0]].reverse(), best, ...points.slice(1).flat()], ends: points.map((list) => list[list.length - 1]) };
    };
    const valleyTraces = (valley, x, y, on = {}) => (valley === null ? [] : [["#000", 5], ["#fff", 2.5]].map(([color, width]) => ({
        type: "scatter", mode: "lines", name: "valley", showlegend: false, hoverinfo: "skip", line: { color, width }, ...on,
        x: valley.way.map((q) => q[x.name]), y: valley.way.map((q) => q[y.name]) })).concat([{
        type: "scatter", mode: "markers", name: "end of the valley", showlegend: false, ...on, x: valley.ends.map((q) => q[x.name]), y: valley.ends.map((q) => q[y.name]),
        marker: { symbol: "square", size: 9, color: "#fff", line: { color: "#000", width: 2 } } }]));
    // The rise of χ² over a pair, all others fitted, over the window of each: logarithmic levels, and the border of what the data accept.
    const pairTraces = (unique, pair, px, py, wx, wy, on = {}) => {
        const limit = unique.landscape.limit;
        const grid = refined(pair, px, py, wx, wy);
        const level = (rise) => (rise === null ? null : Math.log10(Math.max(rise, limit / 30)));
        const place = { type: "contour", x: grid.x, y: grid.y, z: grid.rise.map((row) => row.map(level)), ...on };
        return [{ ...place, coloraxis: "coloraxis", contours: { start: level(0), end: highestLevel(unique), size: 0.25 }, line: { width: 0 },
            text: grid.rise.map((row) => row.map((v) => (v === null ? "no answer" : `χ² rises by ${figure(v)}`))), hoverinfo: "text" },
        { ...place, showscale: false, hoverinfo: "skip", contours: { type: "constraint", operation: "=", value: Math.log10(limit) },
            line: { color: "#D55E00", width: 3 }, name: "accepted", showlegend: false },
        ...valleyTraces(valleyOf(unique), px, py, on), { ...minimaTrace(unique.minima, px, py), ...on }];
    };
    const highestLevel = (unique) => Math.log10(Math.max(10 * unique.landscape.limit, ...unique.landscape.pairs.flatMap((p) => p.rise.flat()).filter((v) => v !== null)));
    const riseColours = (unique, bar = {}) => {
        const ticks = [0.3, 1, 3, 10, 30, 100, 300, 1000, 3000, 10000, 1e5, 1e6].filter((v) => v >= unique.landscape.limit / 30 && Math.log10(v) <= highestLevel(unique));
        return { colorscale: "Cividis", cmin: Math.log10(unique.landscape.limit / 30), cmax: highestLevel(unique),
            colorbar: { title: { text: "rise of χ²" }, thickness: 10, tickvals: ticks.map((v) => Math.log10(v)), ticktext: ticks.map(plain), ...bar } };
    };
    // Of a logarithmic axis over some decades: at 1, 2 and 5, or 1 alone, and none at the ends, where the next panel begins.
    const roundTicks = (p, [low, high]) => {
        if (p.scale !== "log" || high < 3 * low) return {};
        const share = (v) => Math.log(v / low) / Math.log(high / low);
        const at = (factors) => Array.from({ length: 40 }, (_, k) => k - 20).flatMap((k) => factors.map((f) => f * 10 ** k)).filter((v) => share(v) > 0.06 && share(v) < 0.94);
        const tickvals = [[1, 2, 5], [1, 3], [1]].map(at).find((list) => list.length <= 4) || [];
        return { tickvals, ticktext: tickvals.map(plain) };
    };
    // Every pair below the diagonal, on it the profile of each parameter. windows: [low, high] of each.
    const landscapeCorner = (unique, parameters, windows) => {
        const d = parameters.length;
        const gap = 0.02;
        const side = (1 - gap * (d - 1)) / d;
        const limit = unique.landscape.limit;
        const traces = [];
        const layout = { height: Math.max(420, 180 * d + 110), showlegend: false, margin: { l: 84, r: 16, t: 24, b: 84 }, coloraxis: riseColours(unique, { x: 1, xanchor: "right", y: 1, yanchor: "top", len: 0.5 }) };
        parameters.forEach((py, i) => parameters.slice(0, i + 1).forEach((px, j) => {
            const n = i * d + j === 0 ? "" : String(i * d + j + 1);
            const on = { xaxis: "x" + n, yaxis: "y" + n };
            const ends = { showline: true, mirror: true, linecolor: "#999", tickfont: { size: 10 }, automargin: false };
            const along = (p, k, title) => ({ ...parameterAxis(p, windows[k], title), ...roundTicks(p, windows[k]), ...ends });
            const [left, bottom] = [j * (side + gap), (d - 1 - i) * (side + gap)];
            layout["xaxis" + n] = { ...along(px, j, i === d - 1 ? broken(px.name) : ""), domain: [left, left + side], anchor: "y" + n, showticklabels: i === d - 1 };
            layout["yaxis" + n] = i === j ? { ...axis(i === 0 ? "rise of χ²" : "", { range: [-0.12 * limit, 3 * limit], nticks: 4 }), ...ends, domain: [bottom, bottom + side], anchor: "x" + n, showticklabels: i === 0 }
                : { ...along(py, i, j === 0 ? broken(py.name) : ""), domain: [bottom, bottom + side], anchor: "x" + n, showticklabels: j === 0 };
            if (i === j) {
                const profile = unique.landscape.profiles.find((p) => p.name === px.name);
                const known = profile.values.map((v, k) => [v, profile.rise[k]]).filter((q) => q[1] !== null);
                const at = Array.from({ length: 121 }, (_, k) => unitOf(px, windows[j][0]) + (unitOf(px, windows[j][1]) - unitOf(px, windows[j][0])) * k / 120);
                const root = between(known.map((q) => unitOf(px, q[0])), known.map((q) => Math.sqrt(Math.max(0, q[1]))), at);
                traces.push({ type: "scatter", mode: "lines", ...on, x: at.map((u) => valueAt(px, u)), y: root.map((v) => v ** 2), line: { color: colours[0], width: 2 }, hoverinfo: "x+y" },
                    { type: "scatter", mode: "lines", ...on, x: windows[j], y: [limit, limit], line: { color: colours[1], width: 1.5, dash: "dash" }, hoverinfo: "skip" },
                    { ...minimaTrace(unique.minima.slice(0, 1), px, null), ...on });
                return;
            }
            const pair = unique.landscape.pairs.find((p) => p.x === px.name && p.y === py.name);
            if (pair) traces.push(...pairTraces(unique, pair, px, py, windows[j], windows[i], on));
        }));
        return chart("landscape", traces, layout);
    };
    const onePair = (unique, pair, height, windows) => {
        const [px, py] = [pair.x, pair.y].map((n) => unique.parameters.find((p) => p.name === n));
        const [wx, wy] = [px, py].map((p) => windows.get(p.name));
        return chart("landscape", pairTraces(unique, pair, px, py, wx, wy), { xaxis: parameterAxis(px, wx), yaxis: parameterAxis(py, wy), height, coloraxis: riseColours(unique) });
    };
    const mostPanels = 7;
    const landscapePart = (unique) => {
        const found = unique.landscape;
        const parameters = unique.parameters.slice(0, mostPanels);
        const box = parameters.map((p) => [p.min, p.max]);
        const near = parameters.map((p) => around(p, (unique.profiles || []).find((q) => q.name === p.name)));
        const narrow = parameters.some((p, k) => unitOf(p, near[k][1]) - unitOf(p, near[k][0]) < 0.4);
        const byName = (windows) => new Map(parameters.map((p, k) => [p.name, windows[k]]));
        const pairs = found.pairs.filter((p) => byName(box).has(p.x) && byName(box).has(p.y));
        const narrowScreen = window.innerWidth < 600;
        const drawn = (windows) => (narrowScreen ? make("div", { className: "charts" }, pairs.map((p) => onePair(unique, p, 330, byName(windows)))) : landscapeCorner(unique, parameters, windows));
        const choice = make("select", { ariaLabel: "one pair large" }, make("option", { value: "" }, "one pair large: choose"),
            pairs.map((p, k) => make("option", { value: String(k) }, `${wording.titled(p.x)} – ${wording.titled(p.y)}`)));
        const large = make("div");
        choice.addEventListener("change", () => {
            large.textContent = "";
            if (choice.value === "") return;
            large.append(onePair(unique, pairs[Number(choice.value)], Math.min(760, Math.max(360, window.innerWidth - 200)), byName(near)));
            pending.pop()();
        });
        return [part("Landscape of the misfit", true), drawn(box),
            make("p", { className: "soft" }, `Colour: the least rise of χ² over the minimum with all other parameters fitted, by the ${found.model} model; white: no answer. Inside the orange line lies what the data accept (a rise of ${figure(found.limit)} or less). ` +
                `Circles: minima.${valleyOf(unique) ? " White line: the valley that was followed, squares its ends." : ""}${narrowScreen ? "" : " On the diagonal the profile of each parameter."}` +
                (unique.parameters.length > mostPanels ? ` The first ${mostPanels} of ${unique.parameters.length} parameters.` : "")),
            narrow ? [part("The same around what the data accept"), drawn(near)] : [],
            pairs.length > 1 && !narrowScreen ? [make("p", { className: "choice" }, choice), large] : []];
    };

    return { unitOf, valueAt, parameterAxis, minimumMark, minimaTrace, landscapePart };
})();
