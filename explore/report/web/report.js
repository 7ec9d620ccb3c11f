// Draws the report from the JSON of the page. Everything from the data enters as text, never as markup.
"use strict";
(() => {
    const { colours, symbols, dashes, make, figure, plain, signed, broken, part, folded, words, table, pending, chart, axis, scaleOf, scaled, named, smooth } = blocks;
    const { quantity, titled, parameter: inWords, load: loadWords, readingWords, say } = wording;
    const { widest, rejected } = summaries;
    const { unitOf, valueAt, parameterAxis, minimumMark, minimaTrace, landscapePart } = landscapes;
    const data = JSON.parse(document.getElementById("data").textContent);
    const results = data.results;
    const root = document.getElementById("report");
    root.textContent = "";
    wording.readStudies(data.studies);
    wording.knowPaths(((results.compare || {}).studies || []).map((s) => s.study));
    for (const r of Object.values(results)) {
        const listed = [...(Array.isArray(r.parameters) ? r.parameters : []), ...(r.shared || [])].map((p) => p.name);
        wording.knowParameters([...listed, ...Object.keys((r.baseline || {}).parameters || {}), ...(r.stations || []).slice(0, 20).flatMap((s) => Object.keys(s.parameters || {}))].filter(Boolean));
    }

    const shellWord = (word) => (/^[\w./,:=+@%-]+$/.test(word) ? word : "'" + word.replaceAll("'", "'\\''") + "'");

    const sections = [];
    const section = (title, ...children) => {
        const id = "s" + sections.length;
        sections.push({ id, title });
        root.append(make("section", {}, make("h2", { id }, title), ...folded(children)));
    };

    // -- measured against modelled --------------------------------------------------------------------------------

    const groupsOf = (readings) => {
        const groups = new Map();
        readings.forEach((r, i) => {
            const key = `${quantity(r.quantity)} under ${loadWords(r.load)} [${wording.unit(r.unit)}]`;
            if (!groups.has(key)) groups.set(key, []);
            groups.get(key).push({ ...r, index: i });
        });
        return groups;
    };
    const placeOf = (r) => `x = ${plain(r.x_mm)}` + (r.y_mm ? `, y = ${plain(r.y_mm)}` : "") +
        " mm" + (r.depth_mm ? `, ${plain(r.depth_mm)} mm deep` : "") + (r.time_ms === undefined ? "" : `, ${plain(r.time_ms)} ms`);
    // A table without the columns in which all rows are alike: a sentence says what they hold.
    const told = (header, rows, may) => {
        const alike = header.map((h, c) => may.includes(h) && rows.every((r) => r[c] === rows[0][c]));
        const rest = (row) => row.filter((_, c) => !alike[c]);
        const said = header.flatMap((h, c) => (alike[c] && rows[0][c] !== "" && rows[0][c] !== 0 ? [`${h} ${plain(rows[0][c])}`] : []));
        return [said.length ? make("p", { className: "soft" }, `All readings: ${said.join(", ")}.`) : null, table(rest(header), rows.map(rest))];
    };
    // A table of few things with many numbers each: a column a thing, at most four side by side. rows: [name, value of each thing]
    const turned = (names, rows) => {
        const parts = [];
        for (let first = 0; first < names.length; first += 4) {
            const some = (list) => list.slice(first, first + 4);
            parts.push(table(["", ...some(names)], rows.map(([name, ...values]) => [name, ...some(values)])));
        }
        return parts;
    };

    // models: [{name, residuals}], standard deviations in the order of the readings; null: none.
    const residualsPart = (readings, models) => {
        const shown = readings.map((_, i) => i).filter((i) => models.some((m) => typeof m.residuals[i] === "number"));
        if (shown.length === 0) return [];
        const kinds = groupsOf(readings).size > 1;
        const label = (r, i) => `${i + 1}: ${kinds ? `${quantity(r.quantity)} under ${loadWords(r.load)}<br>` : ""}${placeOf(r)}`;
        return [part("Residuals in standard deviations"), chart("residuals", models.map((m, k) => ({
            type: "bar", orientation: "h", name: m.name, y: shown.map((i) => label(readings[i], i)), x: shown.map((i) => m.residuals[i]),
            marker: { color: models.length > 1 && k === 0 ? "#999" : colours[0], pattern: { shape: models.length > 1 && k > 0 ? "/" : "" } },
        })), { xaxis: axis("model - measured [sd]"), yaxis: axis("", { automargin: true, autorange: "reversed", tickfont: { size: 11 } }),
            height: 130 + shown.length * (kinds ? 34 : 22), margin: { l: 64, r: 16, t: 24, b: models.length > 1 ? 90 : 50 }, showlegend: models.length > 1, barmode: "group",
            legend: { orientation: "h", y: -70 / (shown.length * (kinds ? 34 : 22)) },
            shapes: [-2, 2].map((x) => ({ type: "line", yref: "paper", y0: 0, y1: 1, x0: x, x1: x, line: { dash: "dot", color: "#555" } })) })];
    };

    const heading = (r) => `Under ${loadWords(r.load)}`; // the axis says what was read
    // Readings of one kind over time: a colour a place, marks what was measured, lines the models.
    const histories = (name, rows, measured, models) => {
        const traces = [...new Set(rows.map(placeOf))].flatMap((place, p) => {
            const own = rows.filter((r) => placeOf(r) === place).sort((a, b) => a.time_ms - b.time_ms);
            const color = colours[p % colours.length];
            const traceOf = (values, more) => ({ type: "scatter", x: own.map((r) => r.time_ms), y: own.map((r) => values[r.index]), ...more });
            return [traceOf(measured, { mode: "markers", name: place, marker: { symbol: symbols[0], size: 5, color } }),
                ...models.map((m, k) => traceOf(m.values, { mode: "lines", name: `${place}, ${m.name}`, line: { color, dash: dashes[k % dashes.length] } }))];
        });
        return chart("measured", traces, { title: { text: heading(rows[0]) }, xaxis: axis("time [ms]"), yaxis: axis(quantity(rows[0].quantity) + " [" + wording.unit(rows[0].unit) + "]") });
    };

    // models: [{name, values, curves}] beside readings with measured values, in the same order. Where a model has no curve between
    // the readings of a bowl, a monotone cubic joins them; other readings are joined by straight lines.
    const againstMeasured = (readings, measured, models) => {
        let cubic = false;
        const charts = [];
        for (const [name, all] of groupsOf(readings)) {
            const timed = all.filter((r) => r.time_ms !== undefined);
            const rows = all.filter((r) => r.time_ms === undefined);
            if (timed.length > 0) charts.push(histories(name, timed, measured, models));
            if (rows.length === 0) continue;
            const byDepth = new Set(rows.map((r) => r.depth_mm)).size > 1;
            const along = (r) => (byDepth ? r.depth_mm : r.x_mm);
            const sorted = [...rows].sort((a, b) => along(a) - along(b));
            const traceOf = (s, more) => ({ type: "scatter", text: sorted.map(placeOf), x: sorted.map((r) => (byDepth ? s.values[r.index] : r.x_mm)),
                y: sorted.map((r) => (byDepth ? r.depth_mm : s.values[r.index])), name: s.name, ...more });
            const sigma = sorted.map((r) => r.sigma || 0);
            const traces = [traceOf({ name: "measured", values: measured }, { mode: "markers", marker: { symbol: symbols[0], size: 10, color: "#000" },
                ...(sigma.some((v) => v > 0) ? { [byDepth ? "error_x" : "error_y"]: { type: "data", array: sigma, thickness: 1.3, width: 4, color: "#000" } } : {}) })];
            models.forEach((m, k) => {
                const style = { color: colours[k % colours.length], dash: dashes[k % dashes.length] };
                const own = (m.curves || []).filter((c) => c.load === rows[0].load && c.quantity === rows[0].quantity && c.unit === rows[0].unit && c.by_depth === byDepth);
                const at = sorted.map(along);
                const joined = own.length === 0 && rows[0].quantity === "deflection" && at.length > 2 && at.every((v, i) => i === 0 || v > at[i - 1]) &&
                    sorted.every((r) => typeof m.values[r.index] === "number");
                const marker = { symbol: symbols[(k + 1) % symbols.length], size: 7, color: style.color };
                if (own.length === 0 && !joined) {
                    traces.push(traceOf(m, { mode: "lines+markers", line: style, marker }));
                    return;
                }
                cubic = cubic || joined;
                const curves = joined ? [smooth(at, sorted.map((r) => m.values[r.index]))] : own.map((c) => ({ x: c.at_mm, y: c.values }));
                traces.push({ type: "scatter", mode: "lines", name: m.name, line: style, hoverinfo: "skip",
                    x: curves.flatMap((c) => [...(byDepth ? c.y : c.x), null]), y: curves.flatMap((c) => [...(byDepth ? c.x : c.y), null]) },
                traceOf(m, { mode: "markers", showlegend: false, marker }));
            });
            charts.push(chart("measured", traces, byDepth
                ? { title: { text: heading(rows[0]) }, xaxis: axis(quantity(rows[0].quantity) + " [" + wording.unit(rows[0].unit) + "]"),
                    yaxis: axis("depth [mm]", { autorange: "reversed" }) }
                : { title: { text: heading(rows[0]) }, xaxis: axis("distance from the load [mm]"),
                    yaxis: axis(quantity(rows[0].quantity) + " [" + wording.unit(rows[0].unit) + "]",
                        rows[0].quantity === "deflection" ? { autorange: "reversed" } : {}) }));
        }
        const said = [readings.some((r) => r.sigma && r.time_ms === undefined) ? "Bars: one standard deviation." : "",
            models.some((m) => (m.curves || []).length) ? "Between the readings the curve is the model's own." : "",
            cubic ? "Bowls are joined by a monotone cubic through what the model reads at the sensors." : ""].filter(Boolean);
        return make("div", {}, make("div", { className: "charts" }, charts), said.length ? make("p", { className: "soft" }, said.join(" ")) : null);
    };

    let readingsShown = false; // of several commands in one folder the first shows them
    // The charts of the readings of a best fit; null: there are none, or they stand on the page already.
    const readOf = (result) => (result.responses || []).filter((r) => r.measured !== undefined);
    const measuredOf = (result) => againstMeasured(readOf(result), readOf(result).map((r) => r.measured), [{ name: "best fit", values: readOf(result).map((r) => r.value), curves: result.curves }]);
    const responsesPart = (result) => {
        const read = readOf(result);
        if (read.length === 0 || readingsShown) return [];
        readingsShown = true;
        const hasTimes = read.some((r) => r.time_ms !== undefined);
        return [pictured === result ? [] : [part("Measured and modelled", true), measuredOf(result)],
            part("Readings one by one"),
            make("p", { className: "soft" }, "Deflection is positive downwards; strains and stresses are positive in compression."),
            told(["load", "quantity", "x [mm]", "y [mm]", "depth [mm]", ...(hasTimes ? ["time [ms]"] : []), "measured", "model", "difference", "unit"],
                read.map((r) => [loadWords(r.load), quantity(r.quantity), r.x_mm, r.y_mm, r.depth_mm, ...(hasTimes ? [r.time_ms === undefined ? "" : r.time_ms] : []), plain(r.measured), figure(r.value),
                    signed(100 * (r.value - r.measured) / Math.abs(r.measured), 1) + " %", wording.unit(r.unit)]), ["load", "quantity", "y [mm]", "depth [mm]", "unit"]),
            residualsPart(read, [{ name: "best fit", residuals: read.map((r) => r.residual) }])];
    };

    // -- the landscape --------------------------------------------------------------------------------------------

    // haveRanges: better ones stand elsewhere on the page.
    const minimaPart = (minima, haveRanges = false) => {
        if (!minima || minima.length === 0) return [];
        const errorOf = (m, n) => (haveRanges ? "" : (m.not_determined || []).includes(n) ? " (not determined)"
            : typeof (m.standard_errors || {})[n] === "number" ? " ± " + figure(m.standard_errors[n]) : "");
        const cell = (m, n) => figure(m.parameters[n]) + ((m.at_bounds || []).includes(n) ? " (at bound)"
            : m.ranges_95 && m.ranges_95[n] ? ` (${m.ranges_95[n].map(figure).join(" to ")})`
            : errorOf(m, n));
        const shown = minima.slice(0, 8);
        return [part("Minima"), ...turned(shown.map((_, i) => `minimum ${i + 1}`), [
            ["misfit", ...shown.map((m) => figure(m.misfit))],
            ...Object.keys(minima[0].parameters).map((n) => [titled(n), ...shown.map((m) => cell(m, n))]),
            ["starts", ...shown.map((m) => (m.starts || []).length)]]),
        make("p", { className: "soft" }, (haveRanges ? "" : "± one standard error; (a to b): a range of 95 %. ") + (minima.length > shown.length ? ` ${minima.length - shown.length} higher minima are not shown.` : ""))];
    };

    const waterfall = (result) => {
        const ends = [...(result.ends || [])].filter((e) => e.misfit !== undefined).sort((a, b) => a.misfit - b.misfit);
        if (ends.length === 0) return [];
        const open = ends.filter((e) => !e.converged).length;
        if (ends[ends.length - 1].misfit - ends[0].misfit <= 1e-3 * ends[0].misfit) {
            return [part("Where the searches ended"), make("p", {}, `${ends.length === 1 ? "The search" : `All ${ends.length} searches`} ended at the misfit ${figure(ends[0].misfit)}` +
                (open ? `; ${open} did not converge.` : "."))];
        }
        return [part("Where the searches ended"), chart("waterfall", [{
            type: "scatter", mode: "markers+lines", x: ends.map((_, i) => i + 1), y: ends.map((e) => e.misfit),
            text: ends.map((e) => `start ${e.start}, ${e.evaluations} evaluations, ${e.ended || ""}`),
            marker: { size: 8, symbol: ends.map((e) => (e.converged ? "circle" : "circle-open")) },
            line: { dash: "dot" },
        }], { xaxis: axis("searches, best first"), yaxis: axis("misfit", { rangemode: "tozero" }) },
        "A flat beginning: many starts agree on the best minimum. Steps: other minima. Open circles: searches that did not converge.")];
    };

    // Ticks of a logarithmic colour scale.
    const logTicks = (low, high) => {
        const all = [1, 2, 5].flatMap((m) => Array.from({ length: 25 }, (_, i) => m * 10 ** (i - 12))).sort((a, b) => a - b);
        const inside = all.filter((v) => v >= low && v <= high);
        return inside.length > 1 ? inside : [low, high];
    };
    const pairCharts = (parameters, rows, minima) => {
        const charts = [];
        const answered = rows.filter((r) => r[1] !== null);
        const holes = rows.filter((r) => r[1] === null);
        if (answered.length === 0) return null;
        const misfits = answered.map((r) => r[1]).sort((a, b) => a - b);
        const lowest = Math.max(misfits[0], 1e-12);
        const highest = Math.max(misfits[Math.floor((misfits.length - 1) * 0.9)], lowest * 1.01); // of all but the worst tenth
        const ticks = logTicks(lowest, highest);
        const most = 1500; // points of a panel: half of them the lowest, evenly of the rest
        const stride = Math.max(1, Math.ceil((answered.length - most / 2) / (most / 2)));
        const shown = answered.filter((_, i) => i < most / 2 || i % stride === 0).reverse(); // the lowest above the others
        for (let x = 0; x < parameters.length; ++x) {
            for (let y = x + 1; y < parameters.length; ++y) {
                const traces = [{
                    type: "scatter", mode: "markers", name: "computed", showlegend: false, x: shown.map((r) => r[2 + x]), y: shown.map((r) => r[2 + y]),
                    text: shown.map((r) => "misfit " + figure(r[1])), hoverinfo: "text",
                    marker: { size: 4, color: shown.map((r) => Math.log10(Math.min(highest, Math.max(r[1], lowest)))), cmin: Math.log10(lowest), cmax: Math.log10(highest), colorscale: "Cividis",
                        colorbar: { title: { text: "misfit" }, thickness: 10, tickvals: ticks.map((v) => Math.log10(v)), ticktext: ticks.map(plain) } },
                }];
                if (holes.length > 0) {
                    traces.push({ type: "scatter", mode: "markers", name: "no answer", showlegend: false,
                        x: holes.map((r) => r[2 + x]), y: holes.map((r) => r[2 + y]), text: holes.map((r) => r[0]),
                        marker: { symbol: "x-thin", size: 6, line: { width: 1, color: "#888" } } });
                }
                traces.push(minimaTrace(minima, parameters[x], parameters[y]));
                charts.push(chart("pair", traces, {
                    xaxis: parameterAxis(parameters[x]), yaxis: parameterAxis(parameters[y]), height: 330,
                }));
            }
        }
        return make("div", { className: "charts" }, charts);
    };
    // The lowest explored misfit in the cells of pairs of parameters, a mark a cell: what was tried, not a map.
    const projectionCharts = (unique) => {
        const parameter = new Map((unique.parameters || []).map((p) => [p.name, p]));
        const charts = (unique.projections || []).filter((p) => parameter.has(p.x) && parameter.has(p.y)).map((p) => {
            const [px, py] = [parameter.get(p.x), parameter.get(p.y)];
            const tried = p.misfit.map((v, n) => [v, n]).filter(([v]) => v !== null);
            const at = (of, n) => valueAt(of, (n + 0.5) / p.cells);
            return chart("projection", [{
                type: "scatter", mode: "markers", name: "lowest misfit", showlegend: false, x: tried.map(([, n]) => at(px, n % p.cells)), y: tried.map(([, n]) => at(py, Math.floor(n / p.cells))),
                text: tried.map(([v]) => "lowest misfit " + figure(v)), hoverinfo: "text",
                marker: { size: 6, color: tried.map(([v]) => v), colorscale: "Cividis", colorbar: { title: { text: "misfit" }, thickness: 10 } },
            }, minimaTrace(unique.minima, px, py)], { xaxis: parameterAxis(px), yaxis: parameterAxis(py), height: 330 });
        });
        return charts.length > 0 ? make("div", { className: "charts" }, charts) : null;
    };

    // Minima joined at the lowest ways that were found between them: each to a deeper one.
    const passesPart = (unique) => {
        const minima = unique.minima || [];
        const passes = (unique.passes || []).filter((p) => typeof p.rise === "number").sort((a, b) => a.rise - b.rise);
        if (passes.length === 0 || !unique.acceptance) return [];
        const rise = (m) => (m.misfit ** 2 - minima[0].misfit ** 2) / unique.acceptance.residual_variance;
        const deepest = minima.map((_, i) => i); // of what each is joined to so far
        const traces = [];
        for (const p of passes) {
            const [a, b] = [deepest[p.a], deepest[p.b]].sort((i, j) => i - j);
            if (a === b) continue;
            deepest.forEach((of, i) => { if (of === b) deepest[i] = a; });
            traces.push({ type: "scatter", mode: "lines+markers", showlegend: false, x: [b + 1, b + 1, a + 1, a + 1], y: [rise(minima[b]), p.rise, p.rise, rise(minima[a])],
                text: [`minimum ${b + 1}`, `pass ${figure(p.rise)}`, `pass ${figure(p.rise)}`, `minimum ${a + 1}`], line: { color: colours[traces.length % colours.length] }, marker: { size: [9, 1, 1, 9] } });
        }
        const limit = unique.acceptance.chi2_rise_allowed;
        return [part("Minima and the passes between them"), chart("passes", traces, { xaxis: axis("minimum", { dtick: 1 }), yaxis: axis("rise of χ²", { rangemode: "tozero" }),
            shapes: [{ type: "line", xref: "paper", x0: 0, x1: 1, y0: limit, y1: limit, line: { dash: "dash", color: "#555" } }] },
        `Each line rises from a minimum to the lowest way that was found to a deeper one. Minima joined below the dashed line, the rise that the data accept (${figure(limit)}), are one valley.`)];
    };

    // Between the points of a walk a monotone cubic: of the root of the rise with the sign of the side where the best lies inside,
    // for that is nearly a straight line; of the rise itself where the best is an end, or lies elsewhere.
    const walkOf = (points, best, scale) => {
        const at = (v) => (scale === "log" ? Math.log(v) : v);
        const back = (u) => (scale === "log" ? Math.exp(u) : u);
        const rising = [...points].sort((a, b) => a[0] - b[0]).filter((q, i, all) => i === 0 || q[0] > all[i - 1][0]);
        const inside = rising[0][0] < best && rising[rising.length - 1][0] > best && rising.some((q) => q[0] === best);
        const sign = (q) => (q[0] < best ? -1 : 1);
        const curve = smooth(rising.map((q) => at(q[0])), rising.map((q) => (inside ? sign(q) * Math.sqrt(Math.max(0, q[1])) : q[1])));
        return { x: curve.x.map(back), y: curve.y.map((v) => (inside ? v ** 2 : v)) };
    };
    // allowed: the rise that the data accept.
    const profiles = (list, title, name, caption, parameters, allowed) => {
        const known = new Map((parameters || []).map((p) => [p.name, p]));
        const charts = (list || []).filter((p) => (p.profile || []).length > 0).map((p) => {
            const branches = p.profile.length <= 2 ? [[...p.profile.flat(), [p.best, 0]]] : p.profile.filter((b) => b.length > 0);
            const color = (b) => colours[b % colours.length];
            const all = branches.flat().map((q) => q[0]);
            const scale = scaleOf(known.get(p.name));
            const [low, high] = [Math.min(...all), Math.max(...all)];
            const margin = scale === "log" ? (high / low) ** 0.03 : 0.03 * (high - low);
            return chart(name, [...branches.flatMap((points, b) => [
                { type: "scatter", mode: "lines", ...walkOf(points, p.best, scale), name: "branch " + (b + 1), showlegend: branches.length > 1, hoverinfo: "skip", line: { color: color(b), dash: dashes[b % dashes.length] } },
                { type: "scatter", mode: "markers", x: points.map((q) => q[0]), y: points.map((q) => q[1]), showlegend: false, name: "walked", marker: { size: 5, color: color(b) } }]),
            { type: "scatter", mode: "markers", name: "best fit", showlegend: false, x: [p.best], y: [0], marker: minimumMark }],
            { title: { text: titled(p.name) + (p.unit ? ` [${wording.unit(p.unit)}]` : "") }, height: 300,
                shapes: [{ type: "line", xref: "paper", x0: 0, x1: 1, y0: allowed, y1: allowed, line: { dash: "dash", color: "#555" } }],
                xaxis: scale === "log" ? scaled("", scale, low / margin, high * margin) : scaled("", scale, low - margin, high + margin),
                yaxis: axis("rise of χ²", { range: [-0.1 * allowed, 3 * allowed] }) },
            `${figure(p.low)} (ended by ${say(p.low_stopped_by)}) to ${figure(p.high)} (ended by ${say(p.high_stopped_by)}).`);
        });
        return charts.length === 0 ? [] : [part(title), make("p", { className: "soft" }, caption),
            make("div", { className: "charts" }, charts)];
    };

    // sets: [{name, parameters, kind}]
    const parallel = (sets, parameters) => {
        if (sets.length < 2 || !parameters || parameters.length < 2) return [];
        const names = parameters.map((p) => p.name);
        return [part("Acceptable sets side by side"), chart("parallel", sets.map((s, i) => ({
            type: "scatter", mode: "lines+markers", name: s.name, x: names,
            y: parameters.map((p) => unitOf(p, s.parameters[p.name])),
            text: parameters.map((p) => `${titled(p.name)}: ${figure(s.parameters[p.name])}`), hoverinfo: "text+name",
            line: { width: i === 0 ? 4 : 1.5, color: i === 0 ? "#000" : colours[(i - 1) % colours.length],
                dash: dashes[i % dashes.length] }, marker: { size: 6 }, showlegend: sets.length <= 12,
        })), { xaxis: named(names, { range: [-0.35, names.length - 0.65] }), yaxis: axis("place between min and max", { range: [-0.05, 1.05] }), height: 420 },
        "Every line is a set of parameters that the data accept. Where lines spread over the whole height, the data do not fix that parameter.")];
    };

    // -- one section a command ------------------------------------------------------------------------------------

    // The first sentence of a command stands at the top of the page, or of its section where another command's does.
    const isDiagnosed = results.diagnose && results.unique && summaries.rejected(results.unique);
    const summary = [...(isDiagnosed ? ["diagnose"] : []), "unique", "sample", "diagnose", "compare", "fit", "sensitivity", "design", "road", "survey", "map"].find((c) => results[c] && ((results[c].findings || []).length || c === "survey"));
    const opening = (command, about) => {
        const answer = summaries.answerOf(results[command]);
        const said = summaries.detailsOf(results[command]);
        return [command !== summary && answer ? make("p", { className: "verdict" }, answer) : null,
            about ? make("p", { className: "soft" }, about) : null, said.length ? [part("Findings"), words(said)] : null];
    };
    let pictured = null; // the result whose readings are drawn beside the summary
    // Ranges beside each other, each within what was tried: {name, best, low, high, min, max, log}.
    const rangesPicture = (rows) => {
        const share = (q, v) => (q.log ? Math.log(v / q.min) / Math.log(q.max / q.min) : (v - q.min) / (q.max - q.min));
        const names = rows.map((q) => q.name);
        const line = (from, to, width, color, name) => ({ type: "scatter", mode: "lines", name, showlegend: false, hoverinfo: "skip", line: { width, color }, x: rows.flatMap((q) => [from(q), to(q), null]), y: names.flatMap((n) => [n, n, null]) });
        return chart("ranges", [line(() => 0, () => 1, 4, "#d8dde3", "tried"), line((q) => Math.max(0, share(q, q.low)), (q) => Math.min(1, share(q, q.high)), 9, colours[0], "accepted"),
            { type: "scatter", mode: "markers", name: "best", showlegend: false, x: rows.map((q) => share(q, q.best)), y: names, marker: { size: 11, color: "#fff", line: { color: "#000", width: 2 } },
                text: rows.map((q) => `${q.name}: best ${figure(q.best)}, ${figure(q.low)} to ${figure(q.high)}`), hoverinfo: "text" }],
        { xaxis: axis("place within what was tried", { range: [-0.03, 1.03], tickvals: [0, 0.5, 1], ticktext: ["lowest", "middle", "highest"] }), yaxis: axis("", { automargin: true, autorange: "reversed", type: "category" }), height: 120 + 34 * rows.length, margin: { l: 64, r: 24, t: 24, b: 50 } },
        "Blue: what the data accept of each (95 %), within the range that was tried. Circle: the best.");
    };
    // The laws or studies of a comparison, studies by the shortest name that tells them apart; those that have an answer.
    const comparedIn = (r) => (r.laws || r.studies.map((l) => ({ ...l, law: l.study }))).map((l) => ({ ...l, law: say(l.law) }));
    const answeredOf = (r) => comparedIn(r).filter((l) => l.status === "converged");
    const comparedWithMeasured = (r) => againstMeasured(readOf(answeredOf(r)[0]), readOf(answeredOf(r)[0]).map((q) => q.measured), answeredOf(r).map((l) => ({ name: l.law, values: readOf(l).map((q) => q.value) })));
    const pictureOf = (command, r) => {
        const known = new Map(Array.isArray(r.parameters) ? r.parameters.map((p) => [p.name, p]) : []);
        const row = (p, best, low, high) => ({ name: titled(p.name), best, low, high, min: p.min, max: p.max, log: p.scale === "log" });
        if (command === "unique" && (r.profiles || []).length) return rangesPicture(r.profiles.filter((p) => known.has(p.name)).map((p) => row(known.get(p.name), p.best, p.low, p.high)));
        if (command === "sample" && (r.parameters || []).length) return rangesPicture(r.parameters.map((p) => row(p, p.q50, p.q025, p.q975)));
        if ((command === "fit" || command === "unique") && readOf(r).length && groupsOf(readOf(r)).size === 1) {
            pictured = r;
            return measuredOf(r);
        }
        if (command === "compare" && answeredOf(r).length && groupsOf(readOf(answeredOf(r)[0])).size === 1) {
            pictured = r;
            return comparedWithMeasured(r);
        }
        if (command === "diagnose" && (r.hypotheses || []).some((h) => typeof h.probability === "number")) return probabilities(r);
        if (command === "sensitivity" && r.global) return totals(r);
        return command === "design" ? designs.picture(r) : command === "road" || command === "survey" ? roads.picture(r) : null;
    };
    // Of the variance of each response the share that each parameter makes in all.
    const totals = (r) => {
        const list = r.global.indices.slice(0, 6);
        return chart("totals", Object.keys(list[0].total).map((name, k) => ({ type: "bar", orientation: "h", name: titled(name), y: list.map((g) => g.response), x: list.map((g) => g.total[name].value), marker: { color: colours[k % colours.length] } })),
            { barmode: "group", xaxis: axis("share of the variance, with interactions", { rangemode: "tozero", tickformat: ".0%" }), yaxis: axis("", { automargin: true, autorange: "reversed" }),
                height: 180 + list.length * (12 + 14 * Object.keys(list[0].total).length), margin: { l: 64, r: 16, t: 24, b: 100 }, legend: { orientation: "h", y: -70 / (56 + list.length * (12 + 14 * Object.keys(list[0].total).length)) } });
    };
    const probabilities = (r) => {
        // Beside a premise only what another makes probable: all else rests on it.
        const beside = r.hypotheses.some((h) => h.premise) && r.hypotheses.some((h) => h.elsewhere);
        const list = r.hypotheses.filter((h) => typeof h.probability === "number" && (!beside || h.premise || h.elsewhere)).sort((a, b) => b.probability - a.probability).slice(0, 6);
        const short = (text) => {
            const lines = say(text).split(" ").reduce((all, word) => ((all[all.length - 1] + " " + word).length > 34 && all[all.length - 1] ? [...all, word] : [...all.slice(0, -1), `${all[all.length - 1]} ${word}`.trim()]), [""]);
            return lines.slice(0, 2).join("<br>") + (lines.length > 2 ? " …" : "");
        };
        return chart("probabilities", [{ type: "bar", orientation: "h", y: list.map((_, i) => i), x: list.map((h) => h.probability), text: list.map((h) => `${Math.round(100 * h.probability)} %`), textposition: "outside", cliponaxis: false,
            marker: { color: list.map((_, i) => (i === 0 ? colours[0] : "#9aa5ad")) }, hovertext: list.map((h) => say(h.in_words || h.name)), hoverinfo: "text" }],
        { xaxis: axis("probability", { range: [0, 1.08], tickformat: ".0%" }), yaxis: axis("", { automargin: true, autorange: "reversed", tickvals: list.map((_, i) => i), ticktext: list.map((h) => short((h.in_words || h.name).replace(/ \(95 %[^)]*\)/, ""))), tickfont: { size: 11 } }),
            height: 90 + 44 * list.length, margin: { l: 64, r: 44, t: 24, b: 50 }, showlegend: false }, "What may lie behind the residuals, of all that was tried, the most probable first.");
    };
    // An output with its range, the wider where the model may be wrong.
    const outputRow = (o, best, right) => [o.name, figure(best), figure(widest(o).low), figure(widest(o).high), ...(right ? [widest(o).wider ? `${figure(o.low)} to ${figure(o.high)}` : ""] : []), wording.unit(o.unit)];
    const rangesTable = (parameters) => (parameters && parameters.length > 0 && parameters[0].min !== undefined
        ? [part("What was varied"), table(["parameter", "min", "max", "scale"], parameters.map((p) => [titled(p.name), plain(p.min), plain(p.max), p.scale]))]
        : []);

    const showFit = (r) => {
        const rows = data.evaluations && data.evaluations.command !== "unique" ? data.evaluations : null;
        const parameters = r.parameters || [];
        const others = (r.minima || []).map((m, i) => ({ name: "minimum " + (i + 1), parameters: m.parameters }));
        section("The fit",
            opening("fit", `${r.evaluations} evaluations: ${r.explored}, then ${r.starts} searches by ${r.method}.`),
            responsesPart(r), minimaPart(r.minima), waterfall(r), parallel(others, parameters),
            rows && parameters.length > 1 ? [part("Landscape of the misfit"),
                pairCharts(parameters, rows.rows, r.minima),
                make("p", { className: "soft" }, "Each point is a computed set of parameters, coloured by its misfit, the lowest on top; the others differ from point to point. No map of the misfit: pavescape unique --landscape computes one. Circles: minima; crosses: no answer." +
                    (rows.left_out ? ` ${rows.left_out} of the higher points are not drawn.` : ""))] : [],
            rangesTable(parameters), (r.warnings || []).length ? [part("Warnings"), words(r.warnings)] : []);
    };
    const showMap = (r) => {
        const rows = data.evaluations && data.evaluations.command === "map" ? data.evaluations : null;
        const lowest = (r.lowest || []).slice(0, 1);
        section("The map", opening("map", `${r.points} points, ${r.design}.`),
            rows && (r.parameters || []).length > 1 ? [part("Misfit over pairs of parameters", true), pairCharts(r.parameters, rows.rows, lowest)] : null,
            part("Lowest points"), turned(r.lowest.slice(0, 8).map((e) => `point ${e.number}`), [["misfit", ...r.lowest.map((e) => figure(e.misfit))],
                ...(r.parameters || []).map((p) => [titled(p.name), ...r.lowest.map((e) => figure(e.parameters[p.name]))])]),
            rangesTable(r.parameters), statusTable(r.statuses));
    };
    const statusTable = (statuses) => (statuses ? [part("How the forward runs ended"),
        table(["status", "runs"], Object.entries(statuses))] : []);

    // right: the model's own range beside the wider one, which is drawn in any case.
    const outputsChart = (outputs, best, right) => {
        const names = outputs.map((o) => `${o.name}<br>[${wording.unit(o.unit)}]`);
        const line = (name, low, high, width, color) => ({ type: "scatter", mode: "lines", name, hoverinfo: "skip", line: { width, color },
            x: outputs.flatMap((o) => [low(o) / best(o), high(o) / best(o), null]), y: names.flatMap((n) => [n, n, null]) });
        const wider = outputs.some((o) => widest(o).wider);
        const ends = outputs.flatMap((o) => [widest(o).low / best(o), widest(o).high / best(o)]).filter(Number.isFinite);
        const [least, most] = [Math.min(1, ...ends), Math.max(1, ...ends)];
        const margin = 0.3 * (most - least) || 0.1; // bars do not fill the picture
        return chart("outputs", [line(wider ? "also if the model may lack something" : "95 %", (o) => widest(o).low, (o) => widest(o).high, 5, wider ? colours[4] : colours[0]),
            ...(wider && right ? [line("if the model is right", (o) => o.low, (o) => o.high, 10, colours[0])] : []),
            { type: "scatter", mode: "markers", name: "best fit", x: outputs.map(() => 1), y: names, marker: { size: 11, color: "#fff", line: { color: "#000", width: 2 } },
                text: outputs.map((o) => `best ${figure(best(o))}, ${figure(widest(o).low)} to ${figure(widest(o).high)}`), hoverinfo: "text" }],
        { xaxis: axis("relative to the best fit", { range: [least > 0 ? Math.max(0, least - margin) : least - margin, most + margin] }), yaxis: axis("", { automargin: true }), height: 190 + 40 * outputs.length, margin: { l: 64, r: 16, t: 24, b: 90 }, legend: { orientation: "h", y: -70 / (40 * outputs.length + 76) } },
        wider ? "95 % ranges. The wider one is the one to use: it also holds if the model lacks something that these readings cannot show." : "Range of each output over all sets of parameters that the data accept.");
    };
    const outputsTable = (outputs, best, right) => {
        const own = right && outputs.some((o) => widest(o).wider);
        return table(["output", "best", "low", "high", ...(own ? ["if the model is right"] : []), "unit"], outputs.map((o) => outputRow(o, best(o), own)));
    };
    const extent = { flat: "whole range", bounded: "", "bounded on one side": "to a bound" }; // as in the terminal
    const showUnique = (r) => {
        const sets = [];
        (r.minima || []).forEach((m, i) => { if (m.accepted !== false) sets.push({ name: "minimum " + (i + 1), parameters: m.parameters }); });
        for (const p of [...(r.profiles || []), ...(r.outputs || [])]) {
            for (const end of ["low", "high"]) {
                const set = p[end + "_set"];
                if (set && Object.keys(set).length > 0) sets.push({ name: `${end === "low" ? "lowest" : "highest"} ${titled(p.name)}`, parameters: set });
            }
        }
        const rise = r.acceptance ? r.acceptance.chi2_rise_allowed : null;
        const allowed = figure(rise);
        const accepted = r.profiles || [];
        section("Is the answer unique?", opening("unique"),
            accepted.length ? [part("What the data accept (95 %)", true),
                table(["parameter", "best", "low", "high", ""], accepted.map((p) => [titled(p.name), figure(p.best), figure(p.low), figure(p.high), extent[p.kind] ?? p.kind]), [4])] : [],
            (r.outputs || []).length ? [part("What it means for the outputs", true), outputsChart(r.outputs, (o) => o.best, !rejected(r)), outputsTable(r.outputs, (o) => o.best, !rejected(r))] : [],
            responsesPart(r),
            r.landscape && r.landscape.pairs.length > 0 ? landscapePart(r)
                : data.evaluations && data.evaluations.command === "unique" && (r.parameters || []).length > 1
                ? [part("Landscape of the misfit"), pairCharts(r.parameters, data.evaluations.rows, r.minima),
                    make("p", { className: "soft" }, "Each point is a computed set of parameters, coloured by its misfit, the lowest on top; the others differ from point to point. No map of the misfit: pavescape unique --landscape computes one. Circles: minima; crosses: no answer.")]
                : [part("Landscape: lowest explored misfit over pairs"), projectionCharts(r)],
            minimaPart(r.minima, true), passesPart(r),
            profiles(r.profiles, "Profiles of the parameters", "profile",
                `The least rise of χ² at each value with everything else fitted again. Dashed: the rise that the data accept, ${allowed}.`, r.parameters, rise),
            profiles(r.outputs, "Profiles of the outputs", "profile", "The same for each output.", [], rise),
            parallel(sets, r.parameters), directionsPart(r), nextPart(r), rangesTable(r.parameters), statusTable(r.statuses));
    };
    const directionsPart = (r) => {
        const list = r.directions || [];
        if (list.length === 0) return [];
        const names = Object.keys(list[0].vector);
        return [part("Directions, from those that the data determine best to those that they do not determine"), chart("directions", [{
            type: "heatmap", x: names, y: list.map((d, i) => `${i + 1}: ${figure(d.singular_value)}${d.flat ? " (flat)" : ""}`),
            z: list.map((d) => names.map((n) => d.vector[n])), zmin: -1, zmax: 1, colorscale: "RdBu", xgap: 1, ygap: 1,
            texttemplate: "%{z:.2f}",
        }], { yaxis: axis("singular value", { autorange: "reversed", automargin: true, type: "category" }), xaxis: named(names),
            height: 160 + 34 * list.length })];
    };
    const nextPart = (r) => {
        const list = Array.isArray(r.next_measurement) ? r.next_measurement.slice(0, 6) : [];
        const left = (c) => Object.entries({ ...c.standard_error_after_over_before, ...c.outputs_after_over_before })
            .filter(([, v]) => typeof v === "number").map(([n, v]) => `${inWords(n).name} ${(100 * v).toFixed(0)} %`).join(", ");
        return list.length === 0 ? [] : [part("Most informative further readings"),
            table(["reading", "noise", "remaining standard error"], list.map((c) => [say(c.reading), `${figure(c.sigma)} ${wording.unit(c.unit)}`, left(c)]), [0, 2])];
    };

    // The draws over every pair of parameters, and each alone as a histogram, all by their weights.
    const mostInCorner = 7;
    const corner = (parameters, draws, regions) => {
        const shown = parameters.slice(0, mostInCorner);
        const d = shown.length;
        const gap = 0.02;
        const side = (1 - gap * (d - 1)) / d;
        const number = (i, j) => i * d + j + 1; // of a panel's axes
        const key = (n) => (n === 1 ? "" : String(n));
        const most = Math.max(...draws.map((q) => q[0]));
        // From the lowest draw or border to the highest, with a margin, on the scale of the axis.
        const ranges = shown.map((p, k) => {
            const scaled = (v) => (p.scale === "log" ? Math.log10(v) : v);
            const borders = regions.flatMap((q) => q.borders.flat().flatMap(([x, y]) => (q.x === p.name ? [x] : q.y === p.name ? [y] : [])));
            const at = [...draws.map((q) => q[1 + k]), ...borders].map(scaled);
            const [low, high] = [Math.min(...at), Math.max(...at)];
            const margin = 0.06 * (high - low || 1);
            return [Math.max(scaled(p.min), low - margin), Math.min(scaled(p.max), high + margin)];
        });
        const traces = [];
        const layout = { height: Math.max(330, 175 * d + 100), showlegend: false, margin: { l: 70, r: 16, t: 30, b: 70 }, bargap: 0 };
        shown.forEach((py, i) => shown.slice(0, i + 1).forEach((px, j) => {
            const n = key(number(i, j));
            const left = j * (side + gap);
            const bottom = (d - 1 - i) * (side + gap);
            const ends = { showline: true, mirror: true, linecolor: "#999", nticks: 5, tickfont: { size: 10 }, exponentformat: "none" };
            layout["xaxis" + n] = axis(i === d - 1 ? broken(px.name) : "", { ...ends, domain: [left, left + side], anchor: "y" + n, type: scaleOf(px), range: ranges[j], ...(px.scale === "log" ? { tickformat: "~g" } : {}), showticklabels: i === d - 1 });
            layout["yaxis" + n] = axis(i > 0 && j === 0 ? broken(py.name) : "", { ...ends, domain: [bottom, bottom + side], anchor: "x" + n, showticklabels: i > 0 && j === 0,
                ...(i === j ? { rangemode: "tozero" } : { type: scaleOf(py), range: ranges[i] }) });
            const on = { xaxis: "x" + n, yaxis: "y" + n };
            if (i === j) {
                const bins = 24;
                const [low, high] = ranges[j];
                const heights = new Array(bins).fill(0);
                for (const q of draws) {
                    const v = px.scale === "log" ? Math.log10(q[1 + j]) : q[1 + j];
                    heights[Math.min(bins - 1, Math.max(0, Math.floor(bins * (v - low) / (high - low))))] += q[0];
                }
                const edge = (b) => (px.scale === "log" ? 10 ** (low + (high - low) * b / bins) : low + (high - low) * b / bins);
                traces.push({ type: "scatter", mode: "lines", fill: "tozeroy", line: { shape: "hv", color: colours[0], width: 1.2 }, ...on, hoverinfo: "x",
                    x: [...heights.map((_, b) => edge(b)), edge(bins)], y: [...heights, heights[bins - 1]] });
                if (typeof px.q50 === "number") {
                    const tall = Math.max(...heights);
                    for (const [q, dash] of [["q025", "dot"], ["q50", "solid"], ["q975", "dot"]]) {
                        traces.push({ type: "scatter", mode: "lines", ...on, x: [px[q], px[q]], y: [0, tall], hoverinfo: "x", line: { color: colours[1], width: 1.5, dash } });
                    }
                }
            } else {
                traces.push({ type: "scatter", mode: "markers", ...on, x: draws.map((q) => q[1 + j]), y: draws.map((q) => q[1 + i]), hoverinfo: "x+y",
                    marker: { color: colours[0], size: 4, opacity: draws.map((q) => 0.1 + 0.5 * q[0] / most), line: { width: 0 } } });
                const borders = (regions.find((q) => q.x === px.name && q.y === py.name) || { borders: [] }).borders;
                traces.push(...borders.map((border) => ({ type: "scatter", mode: "lines", ...on, x: border.map((q) => q[0]), y: border.map((q) => q[1]), hoverinfo: "skip",
                    line: { color: colours[1], width: 1.5 } })));
            }
        }));
        return chart("corner", traces, layout, "Draws of the posterior, fainter where they weigh less; on the diagonal their histogram, with the median and the 95 % range." +
            (regions.length ? " Inside the line over a pair: 95 % of the draws." : "") +
            (parameters.length > d ? ` The first ${d} of ${parameters.length} parameters.` : ""));
    };
    const showSample = (r) => {
        const parameters = r.parameters || [];
        const rows = [...parameters.map((p) => [p, ""]), ...(r.outputs || []).map((o) => [o, o.unit])];
        section("The posterior", r.reason ? make("p", {}, r.reason) : null, opening("sample", "What the readings leave of every parameter and output."),
            rows.length ? [part("Every parameter and output", summary === "sample"), table(["", "mean", "sd", "2.5 %", "50 %", "97.5 %", "R-hat", "eff. draws"],
                rows.map(([q, unit]) => [titled(q.name) + (unit ? ` [${wording.unit(unit)}]` : ""), ...[q.mean, q.sd, q.q025, q.q50, q.q975].map(figure), q.rhat.toFixed(3), q.ess.toFixed(0)]), [0])] : [],
            (r.draws || []).length && parameters.length ? [part("Draws of the posterior", summary === "sample"), corner(parameters, r.draws, r.regions || [])] : [],
            r.correlations && parameters.length > 1 ? [part("Correlations of the draws"), table(["", ...parameters.map((p) => titled(p.name))],
                parameters.map((p, i) => [titled(p.name), ...r.correlations[i].map((v) => v.toFixed(2))]))] : [],
            r.log_evidence === undefined ? [] : make("p", { className: "soft" }, `Log evidence ${figure(r.log_evidence)} ± ${figure(r.log_evidence_error)}: its difference between models of the same readings is their log odds.`));
    };

    const showPrior = (r) => section("Before any fit", r.reason ? make("p", {}, r.reason) : null, opening("sample-prior", "What the prior predicts of each reading, with its noise."),
        (r.readings || []).length ? [part("Reading by reading", true), table(["reading", "measured", "2.5 %", "50 %", "97.5 %", "unit", "below"],
            r.readings.map((q) => [q.name || `${quantity(q.quantity)} under ${loadWords(q.load)}, ${placeOf(q)}`, ...[q.measured, q.low, q.median, q.high].map(figure), wording.unit(q.unit), q.pit.toFixed(3)]), [0])] : []);

    // A correction over its places: the band, and in grey what is not seen. Depths point downwards.
    const correctionChart = (c) => {
        const down = c.channel === "depth" || c.channel === "level";
        const trace = (x, y, more) => ({ type: "scatter", mode: "lines", [down ? "y" : "x"]: x, [down ? "x" : "y"]: y, ...more });
        const where = axis(`${c.channel} [${c.unit}]`, down ? { autorange: "reversed" } : {});
        const factor = axis(c.layer ? "factor on the modulus" : "factor on the readings", { type: "log" });
        const grey = c.seen.map((seen) => (seen ? colours[0] : "#bbb"));
        return chart("correction", [
            trace([...c.at, ...[...c.at].reverse()], [...c.low, ...[...c.high].reverse()], { fill: "toself", fillcolor: "rgba(120,120,120,0.15)", line: { width: 0 }, name: "95 %", hoverinfo: "skip" }),
            trace(c.at, c.values, { mode: "lines+markers", name: "correction", line: { color: "#777" }, marker: { size: 9, color: grey },
                [down ? "error_x" : "error_y"]: { type: "data", symmetric: false, thickness: 1.3, color: "#777",
                    array: c.high.map((v, i) => v - c.values[i]), arrayminus: c.low.map((v, i) => c.values[i] - v) } }),
        ], { title: { text: c.layer || "readings" }, showlegend: false, [down ? "yaxis" : "xaxis"]: where, [down ? "xaxis" : "yaxis"]: factor,
            shapes: [{ type: "line", line: { dash: "dot", color: "#555" }, ...(down ? { x0: 1, x1: 1, yref: "paper", y0: 0, y1: 1 } : { y0: 1, y1: 1, xref: "paper", x0: 0, x1: 1 }) }] });
    };

    // The fall of chi2 at which the family-wise probability is 5 %, between the candidates on either side of it; null: all are on one.
    const thresholdOf = (candidates) => {
        const list = candidates.filter((c) => typeof c.score_z === "number" && c.p_familywise > 0).map((c) => [c.score_z ** 2, Math.log(c.p_familywise / 0.05)]).sort((a, b) => a[0] - b[0]);
        const above = list.findIndex(([, p]) => p <= 0);
        if (above < 1) return null;
        const [[x0, p0], [x1, p1]] = [list[above - 1], list[above]];
        return p0 > 0 ? x0 + (x1 - x0) * p0 / (p0 - p1) : null;
    };
    const showDiagnose = (r) => {
        const extended = r.residuals.extended.length > 0;
        const fall = (c) => (c.delta_chi2 === null || c.delta_chi2 === undefined ? (c.score_z ?? 0) ** 2 : -c.delta_chi2);
        const candidates = [...(r.candidates || [])].sort((a, b) => fall(b) - fall(a)).slice(0, 20).reverse();
        const threshold = thresholdOf(r.candidates || []);
        const corrections = r.corrections || [];
        const alike = [...(r.confounding || [])].sort((a, b) => Math.abs(a.cosine) - Math.abs(b.cosine));
        section("Does the model hold?",
            opening("diagnose"),
            r.readings && (extended || !readingsShown) ? [part("Measured and modelled, before and after", true), againstMeasured(r.readings, r.responses.measured,
                [{ name: "study's model", values: r.responses.baseline },
                    ...(extended ? [{ name: "extended model", values: r.responses.extended }] : [])])] : [],
            residualsPart(r.readings || [], [{ name: "study's model", residuals: r.residuals.baseline }, ...(extended ? [{ name: "extended model", residuals: r.residuals.extended }] : [])]),
            corrections.length ? [part("Where the model errs"), make("div", { className: "charts" }, corrections.map(correctionChart)),
                make("p", { className: "soft" }, "What multiplies the study's model, with its 95 % band. In grey: places that these readings hardly constrain.")] : [],
            candidates.length ? [part("Candidates: what each effect alone would gain"), chart("candidates", [{
                type: "bar", orientation: "h", y: candidates.map((c) => say(c.effect + (c.on ? " – " + c.on : ""))),
                x: candidates.map(fall),
                marker: { color: candidates.map((c) => (r.causes || []).includes(c.effect) ? colours[1] : colours[5]) },
            }], { xaxis: axis("fall of χ²"), yaxis: axis("", { automargin: true, tickfont: { size: 10 } }), height: 120 + 24 * candidates.length,
                shapes: threshold === null ? [] : [{ type: "line", yref: "paper", y0: 0, y1: 1, x0: threshold, x1: threshold, line: { dash: "dash", color: "#555" } }] },
            (threshold === null ? "" : "Dashed: what one of so many candidates reaches by chance in 5 % of cases. ") + "Full fits where they were made; where not, the square of the score. Causes named are in the darker colour.")] : [],
            alike.length ? [part("Which effects look alike to these data"), chart("confusion", [{
                type: "bar", orientation: "h", x: alike.map((c) => Math.abs(c.cosine)), y: alike.map((c) => `${c.effect} or ${c.other}`),
                text: alike.map((c) => `told apart with a rate of ${figure(100 * c.rate)} %`),
                marker: { color: alike.map((c) => (c.rate < 0.95 ? colours[1] : colours[5])) }, textposition: "none",
            }], { xaxis: axis("|cosine| of what the parameters cannot reproduce", { range: [0, 1] }), yaxis: axis("", { automargin: true, tickfont: { size: 10 } }),
                height: 120 + 22 * alike.length },
            "1: the readings cannot tell the two apart at all. In the darker colour: pairs that would be taken for each other in more than 5 % of cases.")] : [],
            (r.outputs || []).length ? [part("Outputs", summary === "diagnose" || r.verdict !== "adequate"), outputsTable(r.outputs, (o) => o.after ?? o.before, r.verdict === "adequate"),
                extended ? make("p", { className: "soft" }, r.outputs.map((o) => `${o.name}: ${figure(o.before)} by the study's model, ${figure(o.after)} by the extended one.`).join(" ")) : null] : [],
            part("Gain"), table(["", "study's model", "extended model"], [
                ["misfit", r.baseline.misfit, r.extended ? r.extended.misfit : null], ["χ²", r.baseline.chi2, r.extended ? r.extended.chi2 : null],
                ["degrees of freedom", r.baseline.dof, r.extended ? r.extended.dof : null], ["p", r.baseline.p_value, r.extended ? r.extended.p_value : null],
                ["error of readings left out [sigma]", r.gain ? r.gain.held_out_rmse_before : null, r.gain ? r.gain.held_out_rmse_after : null]]));
    };

    const showCompare = (r) => {
        const all = comparedIn(r);
        const good = answeredOf(r);
        const row = (name, of) => [name, ...good.map(of)];
        section(`Which ${r.laws ? "law" : "study"} do the data prefer?`, opening("compare", r.laws ? `Laws of “${r.layer}”.` : "Studies of the same readings."),
            part("Side by side", true), good.length ? turned(good.map((l) => l.law), [row("misfit", (l) => figure(l.misfit)), row("χ²", (l) => figure(l.chi2)), row("degrees of freedom", (l) => l.dof), row("p", (l) => figure(l.p_value)),
                row("AICc", (l) => figure(l.aicc)), row("weight [%]", (l) => (typeof l.weight === "number" ? (100 * l.weight).toFixed(1) : null)), row("left out", (l) => figure(l.held_out_rms)),
                row("held out", (l) => figure(l.study_held_out_rms)), row("answer", (l) => l.verdict)]) : null,
            words(all.filter((l) => l.status !== "converged").map((l) => `${l.law}: ${l.reason}`)),
            make("p", { className: "soft" }, "Left out: error of readings predicted place by place by fits without them; held out: of those that the study holds out."),
            good.length && pictured !== r ? [part("Measured and modelled", true), comparedWithMeasured(r)] : [],
            good.map((l) => [part(l.law), make("p", { className: "soft" }, say(l.summary || "")), table(["", "best", "low", "high"],
                [...Object.entries(l.parameters).map(([n, v]) => [titled(n), ...[v.value, v.low, v.high].map(figure)]), ...l.outputs.map((o) => [`${o.name} [${wording.unit(o.unit)}]`, ...[o.best, widest(o).low, widest(o).high].map(figure)])])]));
    };

    const showSensitivity = (r) => {
        const responses = r.responses.map((s) => s.name);
        section("Sensitivity", opening("sensitivity", `One at a time over ±${plain(r.range_percent)} %.`),
            part("One parameter at a time", true), make("div", { className: "charts" }, responses.slice(0, 12).map((name, i) => chart("curves", r.curves.map((c, k) => ({
                type: "scatter", mode: "lines", name: titled(c.parameter), line: { dash: dashes[k % dashes.length], color: colours[k % colours.length] },
                x: c.points.map((p) => p.change_percent),
                y: c.points.map((p) => (p.responses_change_percent ? p.responses_change_percent[i] : null)),
            })), { title: { text: name }, xaxis: axis("change of the parameter [%]"), yaxis: axis("change [%]") }))),
            r.global ? [part("Sobol indices"), make("div", { className: "charts" }, r.global.indices.slice(0, 12).map((g) => chart("sobol", [
                ["first order", g.first_order], ["total", g.total]].map(([name, set], k) => ({
                type: "bar", name, x: Object.keys(set), y: Object.values(set).map((e) => e.value),
                marker: { color: colours[k], pattern: { shape: k ? "/" : "" } },
                error_y: { type: "data", symmetric: false, array: Object.values(set).map((e) => e.high - e.value),
                    arrayminus: Object.values(set).map((e) => e.value - e.low) },
            })), { title: { text: g.response }, yaxis: axis("share of the variance"), xaxis: named(Object.keys(g.total)), barmode: "group" })))] : []);
    };

    const show = { "sample-prior": showPrior, unique: showUnique, sample: showSample, diagnose: showDiagnose, compare: showCompare, fit: showFit, map: showMap, sensitivity: showSensitivity, design: (r) => designs.show(section, r, opening("design")), survey: (r) => roads.showSurvey(section, r, r.findings || []), road: (r) => roads.showRoad(section, r, r.findings || []) };

    // -- the page -------------------------------------------------------------------------------------------------

    // A road's study may be that of one station.
    const road = results.survey || results.road;
    const titles = road && road.files ? [`${results.survey ? "Survey" : "Road"} of ` + road.files.map((f) => f.split("/").pop()).join(", ")]
        : [...new Set(Object.values(results).map((r) => r.study && r.study.title).filter(Boolean))];
    document.title = (titles[0] || data.folder) + " – Pavescape";
    const navigation = make("nav");
    root.append(make("header", {}, make("h1", {}, titles[0] || data.folder),
        make("p", { className: "soft" }, `Pavescape ${data.version}, run “${data.folder}”: ${Object.keys(results).join(", ") || "not finished"}`)), navigation);
    // A sentence with a command in it, which is set as one.
    const withCommand = (text) => text.split(/(pavescape (?:unique|diagnose|fit) \S+)/).map((piece, i) => (i % 2 === 1 ? make("code", {}, piece) : piece));
    const summed = !summary ? null : summary === "road" || summary === "survey" ? roads.summaryOf(results[summary]) : summary === "design" ? designs.summaryOf(results.design) : summaries.summaryOf(summary, results[summary]);
    if (summed) {
        const picture = pictureOf(summary, results[summary]);
        root.append(make("section", { id: "summary", className: picture ? "with-picture" : "" }, make("div", { className: "said" },
            make("p", { className: "verdict" }, summed.verdict), summed.named ? make("p", { className: "named" }, make("strong", {}, summed.named[0]), summed.named[1]) : null), picture,
        make("div", { className: "rest" }, summed.numbers.length ? table(["", summed.value || "best", summed.range || "95 % range", ""], summed.numbers.map((n) => [n.name, n.value, n.range, n.unit]), [0, 3]) : null,
            summed.action ? make("p", { className: "next" }, make("strong", {}, "Next: "), withCommand(summed.action.replace(/^Measure next: (.)/, (_, c) => `measure the ${c}`))) : null)));
    }
    for (const [command, draw] of Object.entries(show)) {
        if (results[command]) draw(results[command]);
    }
    if (Object.keys(results).length === 0) {
        section("An unfinished run", make("p", {}, `No command has finished here yet. ${data.evaluations.rows.length} evaluations of “${data.evaluations.command}” are kept; the same command goes on from them.`));
    }
    const builds = Math.max(0, ...Object.values(results).map((r) => ((r.reduced_model || {}).loads || []).reduce((sum, l) => sum + l.full_runs, 0)));
    section("How it was computed",
        data.sessions.length ? [part("Timings"), table(["began (UTC)", "command", "threads", "runs", "seconds", "runs/s"],
            data.sessions.map((s) => [s.began.replace("T", " ").replace("Z", ""), "pavescape " + s.arguments.map(shellWord).join(" "), s.threads,
                s.evaluations, figure(s.seconds), figure(s.evaluations / s.seconds)]), [1]),
        make("p", { className: "soft" }, "Wall time from opening the folder to the last forward run that was computed there; what was found in the folder is not counted again." +
            (builds ? ` Nor is the building of the reduced model, of ${builds} full runs.` : ""))] : [],
        part("What this rests on"),
        make("ul", {}, Object.entries(results).map(([command, r]) => make("li", {}, [`${command}: program ${r.version || data.version}`,
            r.seed !== undefined ? `seed ${r.seed}` : "", r.misfit_kind ? `misfit ${r.misfit_kind}` : "",
            r.noise ? `noise ${r.noise.source || r.noise}` : "", r.runs_per_second ? `${figure(r.runs_per_second)} forward runs a second` : "",
            r.study ? `study hash ${r.study.hash}` : ""].filter(Boolean).join(", ")))),
        make("p", { className: "soft" }, [...new Set(data.sessions.map((s) => `Computed by pavescape ${s.version} with ${s.libraries}.`))].join(" ")),
        [...new Set(Object.values(results).map((r) => r.study && r.study.model_words).filter(Boolean))].map((words) => make("p", { className: "soft" }, words)),
        data.studies.flatMap((s) => [part(`The study: ${s.file}`), s.note ? make("p", {}, s.note) : make("pre", {}, s.text)]));
    if (sections.length < 3) navigation.remove();
    for (const { id, title } of sections) navigation.append(make("a", { href: "#" + id }, title));
    for (const draw of pending) draw();
    // Paper has no folds: what was found is printed.
    const findings = [...document.querySelectorAll("details")].filter((d) => d.querySelector("summary").textContent === "Findings");
    window.addEventListener("beforeprint", () => findings.forEach((d) => { d.open = true; }));
    document.documentElement.dataset.charts = String(pending.length);
})();
