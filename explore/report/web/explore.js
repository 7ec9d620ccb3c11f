// A study under someone's hands: sliders, what the model reads there, the landscape, readings taken to be others.
(() => {
    const { note, colours, make, figure, plain, signed, part, table, dressed, axis, scaled, smooth } = blocks;
    const root = document.getElementById("explore");
    root.textContent = "";
    const token = new URLSearchParams(window.location.search).get("token");

    // -- the server -----------------------------------------------------------------------------------------------

    const trouble = make("p", { className: "trouble", hidden: true, role: "alert" });
    const ask = async (what, parameters = {}) => {
        const query = new URLSearchParams({ ...parameters, token });
        let answer;
        try {
            answer = await fetch(`/${what}?${query}`);
        } catch {
            trouble.textContent = "The program no longer answers: start `pavescape explore` again and open the address that it prints.";
            trouble.hidden = false;
            return null;
        }
        const json = await answer.json();
        trouble.hidden = answer.ok;
        if (!answer.ok) trouble.textContent = json.error || "The program refused this.";
        return answer.ok ? json : null;
    };
    // Calls work() again and again while more is wanted, one call at a time: the last request is done last.
    // Each call answers a promise that is kept when nothing more is wanted.
    const latest = (work) => {
        let running = null;
        let again = false;
        const run = async () => {
            while (again) {
                again = false;
                try {
                    await work();
                } catch (e) {
                    note(e);
                }
            }
            running = null;
        };
        return () => {
            again = true;
            running ??= run();
            return running;
        };
    };
    const after = (pause, work) => {
        let timer;
        return () => {
            clearTimeout(timer);
            timer = setTimeout(work, pause);
        };
    };

    // -- numbers --------------------------------------------------------------------------------------------------

    const unitOf = (p, v) => (p.scale === "log" ? Math.log(v / p.min) / Math.log(p.max / p.min) : (v - p.min) / (p.max - p.min));
    const valueAt = (p, u) => (p.scale === "log" ? p.min * (p.max / p.min) ** u : p.min + u * (p.max - p.min));
    const within = (p, v) => Math.min(p.max, Math.max(p.min, v));
    const exact = (v) => String(Number(v.toPrecision(12)));
    const begin = (state) => {
        const { parameters, readings, outputs } = state;
        let here = state.minima[0].at.slice(); // where the sliders stand
        let point = null; // what the model reads there
        let lowest = null; // the minimum with the readings as they are taken to be
        let full = null, grid = null; // the full model's answer here; the landscape that is drawn
        const taken = readings.map((r) => r.measured);
        const first = state.minima[0];
        const changes = () => readings.flatMap((r, i) => (taken[i] === r.measured ? [] : [`${i}:${exact(taken[i])}`])).join(",");
        const place = () => ({ at: here.map(exact).join(","), ...(changes() ? { changed: changes() } : {}) });
        const bestChi2 = () => (lowest || first).chi2;

        // -- what is said of the point ----------------------------------------------------------------------------

        const sentence = make("p", { className: "state", role: "status", ariaLive: "polite" });
        const say = () => {
            if (!point || point.status !== "converged") {
                sentence.className = "state nothing";
                sentence.textContent = point ? `No answer here: ${point.reason}` : "";
                return;
            }
            const rise = point.chi2 - bestChi2();
            const accepted = state.limit === null || rise <= state.limit;
            const p = (lowest || first).p_value ?? 1, contradicted = p < 0.01; // then the readings accept no point at all
            sentence.className = accepted && !contradicted ? "state" : "state outside";
            sentence.textContent = `χ² = ${figure(point.chi2)}, ${rise < 5e-4 ? "the minimum" : figure(rise) + " above the minimum"}` +
                (state.limit === null ? "" : contradicted
                    ? `: by their stated noise the readings reject every point of this model (p = ${p.toPrecision(2)} at the minimum). ` +
                        `With an error as large as the residuals of the best fit this point lies ${accepted ? "within" : "outside"} what is left (a rise of ${figure(state.limit)}).`
                    : `: the readings ${accepted ? "accept" : "reject"} this point (a rise of ${figure(state.limit)} above the minimum is accepted).`) +
                (point.full && state.model === "reduced" ? " The full model answered: the reduced one is not sure here." : "");
        };

        // -- the charts of the readings ---------------------------------------------------------------------------

        const groups = [];
        const keyOf = (g, r) => JSON.stringify([g.overTime || g.byDepth ? r.x_mm : null, g.byDepth ? null : r.depth_mm, r.y_mm, r.gauge_mm]); // of its line
        const curvesOf = (g, curves) => curves.filter((c) => c.load === g.load && c.quantity === g.quantity && c.by_depth === g.byDepth && !g.overTime)
            .map((c) => ({ key: keyOf(g, c), x: c.at_mm, y: c.values.map((v) => v * c.to_si / g.to_si) }));
        readings.forEach((r, i) => {
            let group = groups.find((g) => g.load === r.load && g.quantity === r.quantity && g.overTime === (r.time_ms !== undefined));
            if (!group) groups.push(group = { overTime: r.time_ms !== undefined, load: r.load, quantity: r.quantity, rows: [], unit: r.unit_words, to_si: r.to_si, title: `${r.load}: ${r.quantity_words}` });
            group.rows.push(i);
        });
        for (const g of groups) {
            g.byDepth = !g.overTime && new Set(g.rows.map((i) => readings[i].depth_mm)).size > 1;
            g.along = (i) => (g.overTime ? readings[i].time_ms : g.byDepth ? readings[i].depth_mm : readings[i].x_mm);
            g.rows.sort((a, b) => g.along(a) - g.along(b));
            g.factor = (i) => readings[i].to_si / g.to_si;
            // Readings of one line, whose places differ.
            g.lines = [];
            for (const i of g.rows) {
                const key = keyOf(g, readings[i]);
                const line = g.lines.find((l) => l.key === key) || g.lines[g.lines.push({ key, rows: [] }) - 1];
                if (line.rows.length === 0 || g.along(line.rows[line.rows.length - 1]) < g.along(i)) line.rows.push(i);
            }
            g.place = make("div", { className: "chart" });
            g.place.dataset.chart = "readings";
        }
        // The full model's curve at the minimum, scaled, and bent by a cubic to what the model reads at the sensors.
        const curveOf = (g, values, extra) => {
            const x = [];
            const y = [];
            for (const line of g.lines) {
                const known = line.rows.filter((i) => values[i] !== null);
                const at = known.map(g.along);
                const read = known.map((i) => values[i] * g.factor(i));
                const reference = curvesOf(g, state.curves).find((c) => c.key === line.key);
                if (!reference || known.length < line.rows.length) {
                    const curve = smooth(at, read);
                    x.push(...curve.x, null);
                    y.push(...curve.y, null);
                    continue;
                }
                const of = at.map((v) => reference.y[reference.x.indexOf(v)]);
                const scale = of.reduce((sum, v, k) => sum + v * read[k], 0) / of.reduce((sum, v) => sum + v * v, 0);
                const bend = smooth(at, read.map((v, k) => v - scale * of[k]), reference.x);
                x.push(...reference.x, null);
                y.push(...reference.y.map((v, k) => scale * v + bend.y[k]), null);
            }
            return { type: "scatter", mode: "lines", x: g.byDepth ? y : x, y: g.byDepth ? x : y, hoverinfo: "skip", ...extra };
        };
        const drawReadings = () => Promise.all(groups.map((g) => {
            const at = g.rows.map(g.along);
            const of = (list) => g.rows.map((i) => (list[i] === null ? null : list[i] * g.factor(i)));
            const marks = (list, extra) => ({ type: "scatter", mode: "markers", x: g.byDepth ? of(list) : at, y: g.byDepth ? at : of(list),
                text: g.rows.map((i) => readings[i].words), ...extra });
            const sigma = g.rows.map((i) => (readings[i].sigma === null ? 0 : readings[i].sigma * g.factor(i)));
            const bars = sigma.some((s) => s > 0) ? { [g.byDepth ? "error_x" : "error_y"]: { type: "data", array: sigma, thickness: 1.3, width: 4, color: "#000" } } : {};
            const traces = [];
            if (lowest) traces.push(curveOf(g, lowest.values, { name: "minimum", line: { color: "#777", width: 1.5, dash: "dot" } }));
            const answered = point && point.status === "converged";
            traces.push(answered ? curveOf(g, point.values, { name: "model", line: { color: colours[0], width: 2.5 } }) : { name: "model", x: [], y: [] });
            if (answered) traces.push(marks(point.values, { name: "model", showlegend: false, marker: { color: colours[0], size: 6 } }));
            if (full) {
                const own = curvesOf(g, full.curves);
                own.forEach((c, k) => traces.push({ type: "scatter", mode: "lines", name: "full model", showlegend: k === 0, hoverinfo: "skip",
                    line: { color: colours[2], width: 2, dash: "dash" }, x: g.byDepth ? c.y : c.x, y: g.byDepth ? c.x : c.y }));
                traces.push(marks(full.values, { name: "full model", showlegend: own.length === 0, marker: { color: colours[2], size: 9, symbol: "diamond-open", line: { width: 2 } } }));
            }
            if (changes()) traces.push(marks(readings.map((r) => r.measured), { name: "as measured", marker: { color: "#777", size: 9, symbol: "circle-open" } }));
            traces.push(marks(taken, { name: changes() ? "taken to be" : "measured", marker: { color: "#000", size: 10,
                symbol: g.rows.map((i) => (readings[i].fitted ? "circle" : "square-open")) }, ...bars }));
            const ends = (list) => {
                const known = list.filter((v) => v !== null && v !== undefined);
                const low = Math.min(...known);
                const high = Math.max(...known);
                const margin = 0.07 * (high - low || Math.abs(high) || 1);
                return [low - margin, high + margin];
            };
            const wanted = ends([...traces.flatMap((t) => (g.byDepth ? t.x : t.y)), ...g.rows.flatMap((i, k) => [-1, 1].map((side) => taken[i] * g.factor(i) + side * sigma[k]))]);
            const size = (r) => r[1] - r[0];
            // The axis stays while the values fit in it: it is cheaper to draw, and easier to see what moves.
            if (!g.range || wanted[0] < g.range[0] || wanted[1] > g.range[1] || size(wanted) < 0.6 * size(g.range)) g.range = wanted;
            const value = axis(`${readings[g.rows[0]].quantity_words} (${g.unit})`, { range: g.quantity === "deflection" && !g.overTime ? [g.range[1], g.range[0]] : g.range });
            const layout = dressed({ height: 350, title: { text: g.title }, dragmode: false, margin: { l: 64, r: 12, t: 36, b: 80 }, legend: { orientation: "h", y: -0.24 },
                xaxis: g.byDepth ? value : axis(g.overTime ? "time (ms)" : "distance from the load (mm)", { range: ends(at) }), yaxis: g.byDepth ? axis("depth (mm)", { range: ends(at).reverse() }) : value });
            // Lines that move with a slider are drawn alone, over axes and legend that stay, at half the cost of drawing them again.
            const places = traces.map(({ x, y }) => JSON.stringify([x, y]));
            const rest = JSON.stringify([layout, traces.map(({ x, y, ...others }) => others)]);
            const moving = places.map((_, k) => k).filter((k) => g.drawn && places[k] !== g.drawn.places[k]);
            const same = g.drawn && g.drawn.rest === rest;
            g.drawn = { places, rest };
            if (!same) return Plotly.react(g.place, traces, layout, { displayModeBar: false, responsive: true });
            return moving.length && Plotly.animate(g.place, { data: moving.map((k) => ({ x: traces[k].x, y: traces[k].y })), traces: moving },
                { mode: "immediate", frame: { duration: 0, redraw: false }, transition: { duration: 0 } });
        }));
        // A measured point is dragged along the axis of its value.
        const draggable = (g) => {
            const near = (event) => {
                const box = g.place.getBoundingClientRect();
                const { xaxis, yaxis } = g.place._fullLayout;
                const px = (i) => (g.byDepth ? taken[i] * g.factor(i) : g.along(i));
                const py = (i) => (g.byDepth ? g.along(i) : taken[i] * g.factor(i));
                return g.rows.map((i) => [i, Math.hypot(xaxis._offset + xaxis.d2p(px(i)) + box.left - event.clientX, yaxis._offset + yaxis.d2p(py(i)) + box.top - event.clientY)])
                    .sort((a, b) => a[1] - b[1]).filter((e) => e[1] < 16).map((e) => e[0])[0];
            };
            let held;
            g.place.addEventListener("pointerdown", (event) => {
                held = near(event);
                if (held === undefined) return;
                g.place.setPointerCapture(event.pointerId);
                event.preventDefault();
                event.stopPropagation();
            }, true);
            g.place.addEventListener("pointermove", (event) => {
                if (held === undefined) {
                    g.place.classList.toggle("dragged", near(event) !== undefined);
                    return;
                }
                const box = g.place.getBoundingClientRect();
                const { xaxis, yaxis } = g.place._fullLayout;
                const value = g.byDepth ? xaxis.p2d(event.clientX - box.left - xaxis._offset) : yaxis.p2d(event.clientY - box.top - yaxis._offset);
                take(held, value / g.factor(held));
                event.stopPropagation();
            }, true);
            const release = () => { held = undefined; };
            g.place.addEventListener("pointerup", release, true);
            g.place.addEventListener("pointercancel", release, true);
        };

        // -- the table of the readings ----------------------------------------------------------------------------

        const moved = make("div");
        const cells = readings.map((r, i) => {
            const field = make("input", { type: "number", value: plain(r.measured), step: "any", ariaLabel: `${r.words} under ${r.load}, taken to be (${r.unit_words})` });
            field.addEventListener("change", () => take(i, field.value === "" ? r.measured : Number(field.value)));
            const times = (text, factor, title) => {
                const button = make("button", { type: "button", title: `${title}: ${r.words}` }, text);
                button.addEventListener("click", () => take(i, factor === null ? r.measured : taken[i] * factor));
                return button;
            };
            const now = make("td");
            const off = make("td");
            const byFull = make("td");
            now.dataset.label = "model";
            off.dataset.label = "off (sd)";
            byFull.dataset.label = "full model";
            const row = make("tr", { className: "reading" }, make("td", {}, `${groups.length > 1 ? r.load + ", " : ""}${r.words}${r.fitted ? "" : " (held out)"}`), make("td", {}, field),
                make("td", {}, times("−5 %", 0.95, "5 % less"), " ", times("+5 %", 1.05, "5 % more"), " ", times("↺", null, "as measured")), make("td", {}, r.unit_words), now, off, byFull);
            return { field, now, off, byFull, row };
        });
        const outputCells = outputs.map(() => ({ now: make("td"), best: make("td"), byFull: make("td") }));
        const beyond = make("p", { className: "soft", hidden: true }, "–: under a load that is not fitted. The full model computes it on the button.");
        const fill = () => {
            const answered = point && point.status === "converged";
            const set = (cell, text) => { if (cell.textContent !== text) cell.textContent = text; };
            cells.forEach((c, i) => {
                set(c.now, answered ? figure(point.values[i]) : "–");
                set(c.off, answered && point.residuals[i] !== null ? signed(point.residuals[i], 2) : "–");
                set(c.byFull, full ? figure(full.values[i]) : "");
                c.row.classList.toggle("changed", taken[i] !== readings[i].measured);
            });
            beyond.hidden = !answered || !point.outputs.includes(null);
            outputCells.forEach((c, i) => {
                set(c.now, answered ? figure(point.outputs[i]) : "–");
                set(c.best, lowest ? figure(lowest.outputs[i]) : "–");
                set(c.byFull, full ? figure(full.outputs[i]) : "");
            });
        };
        const sayMoved = () => {
            moved.textContent = "";
            if (!changes() || !lowest) return;
            const error = (p) => first.standard_errors[p.name]; // wider than the range: it says nothing
            moved.append(part("How the minimum moves"), table(["parameter", "as measured", "with these readings", "change", "in standard errors"], parameters.map((p, k) => {
                const from = first.at[k];
                const to = lowest.at[k];
                return [p.words, from, to, from === 0 ? "–" : `${signed(100 * (to - from) / Math.abs(from), 1)} %`, error(p) && error(p) < p.max - p.min ? signed((to - from) / error(p), 2) : "–"];
            })), make("p", { className: "soft" }, `χ² of the minimum: ${figure(first.chi2)} as measured, ${figure(lowest.chi2)} with these readings` +
                (lowest.on_bound.length ? `; ${lowest.on_bound.join(", ")}.` : ".")));
        };

        // -- the landscape ----------------------------------------------------------------------------------------

        const pairs = parameters.flatMap((_, x) => parameters.slice(x + 1).map((__, k) => [x, x + 1 + k]));
        const pairField = make("select", { ariaLabel: "pair of parameters" }, pairs.map(([x, y], i) => make("option", { value: i }, `${parameters[x].words} – ${parameters[y].words}`)));
        const fittedField = make("input", { type: "checkbox" });
        const lines = 25;
        const slow = state.seconds_a_point * lines * lines > 8;
        const computeButton = make("button", { type: "button", hidden: !slow }, "compute the landscape");
        const landscapePlace = make("div", { className: "chart" });
        landscapePlace.dataset.chart = "landscape";
        const mark = make("div", { className: "here", title: "here" }); // over the chart: it moves without drawing the chart again
        const moveMark = () => {
            const [x, y] = pairs[Number(pairField.value)];
            const { xaxis, yaxis } = landscapePlace._fullLayout;
            mark.style.left = `${xaxis._offset + xaxis.d2p(here[x])}px`;
            mark.style.top = `${yaxis._offset + yaxis.d2p(here[y])}px`;
        };
        const landscapeNote = make("figcaption");
        let followed = false;
        const drawLandscape = () => {
            const [x, y] = pairs[Number(pairField.value)];
            const px = parameters[x];
            const py = parameters[y];
            const traces = [];
            if (grid && grid.x === px.name && grid.y === py.name) {
                const limit = state.limit === null ? 1 : state.limit;
                const least = limit / 30;
                const level = (v) => (v === null ? null : Math.log10(Math.max(v - grid.lowest, least / 2)));
                const z = grid.chi2.map((row) => row.map(level));
                const most = Math.max(...z.flat().filter((v) => v !== null), Math.log10(10 * limit));
                const ticks = [0.1, 0.3, 1, 3, 10, 30, 100, 300, 1e3, 3e3, 1e4, 1e5, 1e6].filter((v) => v >= least && Math.log10(v) <= most);
                const on = { type: "contour", x: grid.x_values, y: grid.y_values, z };
                traces.push({ ...on, colorscale: "Cividis", zmin: Math.log10(least), zmax: most, line: { width: 0 },
                    contours: { start: Math.log10(least), end: most, size: 0.25 }, hoverinfo: "text",
                    text: grid.chi2.map((row, j) => row.map((v, i) => `${px.words} ${figure(grid.x_values[i])}<br>${py.words} ${figure(grid.y_values[j])}<br>` +
                        (v === null ? "no answer" : `χ² rises by ${figure(v - grid.lowest)}`))),
                    colorbar: { title: { text: "rise of χ²" }, thickness: 10, tickvals: ticks.map(Math.log10), ticktext: ticks.map(plain) } },
                { ...on, showscale: false, hoverinfo: "skip", showlegend: false, contours: { type: "constraint", operation: "=", value: Math.log10(limit) }, line: { color: "#D55E00", width: 3 } });
            }
            const star = (m, name, extra) => ({ type: "scatter", mode: "markers", name, x: [m.at[x]], y: [m.at[y]], marker: { symbol: "star", size: 9, line: { color: "#000", width: 1 }, ...extra } });
            state.minima.forEach((m, k) => traces.push(star(m, state.minima.length > 1 ? `minimum ${k + 1}` : "minimum", { color: changes() ? "#ccc" : colours[1] })));
            if (changes() && lowest) {
                traces.push({ type: "scatter", mode: "lines", showlegend: false, hoverinfo: "skip", x: [first.at[x], lowest.at[x]], y: [first.at[y], lowest.at[y]], line: { color: colours[1], width: 2 } },
                    star(lowest, "with these readings", { color: colours[1] }));
            }
            const along = (p) => scaled(p.words, p.scale, p.min, p.max);
            return Plotly.react(landscapePlace, traces, dressed({ height: 450, dragmode: false, margin: { l: 70, r: 10, t: 14, b: 100 }, legend: { orientation: "h", y: -0.2 },
                xaxis: along(px), yaxis: along(py) }), { displayModeBar: false, responsive: true }).then(() => {
                if (!followed) landscapePlace.on("plotly_afterplot", moveMark); // drawn again in another size
                followed = true;
                moveMark();
            });
        };
        const computeLandscape = latest(async () => {
            if (pairs.length === 0) return;
            const [x, y] = pairs[Number(pairField.value)];
            const fitted = fittedField.checked;
            landscapeNote.textContent = "computing ...";
            const answer = await ask("landscape", { ...place(), x, y, lines: fitted ? 15 : lines, fitted: fitted ? 1 : 0 });
            landscapeNote.textContent = `${fitted ? "χ² with the other parameters fitted at every point." : "χ² with the other parameters as on the sliders."} ` +
                (state.limit === null ? "" : state.noise.widened ? "Orange line: the border of what is left with an error as large as the residuals of the best fit. " : "Orange line: the border of what the readings accept. ") + "Click or drag in it to move there.";
            if (!answer || answer.status !== "computed") return;
            grid = answer;
            await drawLandscape();
        });
        const landscapeSoon = after(120, () => { if (!slow) computeLandscape(); });
        computeButton.addEventListener("click", computeLandscape);
        pairField.addEventListener("change", () => { drawLandscape(); landscapeSoon(); });
        fittedField.addEventListener("change", landscapeSoon);
        const walk = (event) => {
            const box = landscapePlace.getBoundingClientRect();
            const { xaxis, yaxis } = landscapePlace._fullLayout;
            const u = event.clientX - box.left - xaxis._offset;
            const v = event.clientY - box.top - yaxis._offset;
            if (u < 0 || v < 0 || u > xaxis._length || v > yaxis._length) return;
            const [x, y] = pairs[Number(pairField.value)];
            const at = here.slice();
            at[x] = within(parameters[x], xaxis.p2d(u));
            at[y] = within(parameters[y], yaxis.p2d(v));
            go(at, [x, y]);
        };
        landscapePlace.addEventListener("pointerdown", walk, true);
        landscapePlace.addEventListener("pointermove", (event) => { if (event.buttons === 1) walk(event); }, true);

        // -- moving -----------------------------------------------------------------------------------------------

        let updates = 0;
        let waits = false;
        // Once a frame, while the next answer is on its way.
        const draw = () => {
            if (waits) return;
            waits = true;
            requestAnimationFrame(() => {
                waits = false;
                say();
                fill();
                if (pairs.length && landscapePlace._fullLayout) moveMark();
                drawReadings().then(() => { document.documentElement.dataset.updates = String(++updates); }).catch(note);
            });
        };
        const update = latest(async () => {
            const answer = await ask("evaluate", place());
            if (!answer) return;
            point = answer;
            draw();
        });
        const sliders = parameters.map((p, k) => {
            const range = make("input", { type: "range", min: 0, max: 1000, step: 1, id: "p" + k });
            const field = make("input", { type: "number", step: "any", ariaLabel: p.words + ", as a number" });
            range.addEventListener("input", () => {
                const at = here.slice();
                at[k] = valueAt(p, Number(range.value) / 1000);
                go(at, [k]);
            });
            field.addEventListener("change", () => {
                const at = here.slice();
                at[k] = within(p, Number(field.value) || p.min);
                go(at, [k]);
            });
            return { range, field, box: make("div", { className: "slider" }, make("label", { htmlFor: "p" + k }, p.words), make("div", { className: "row" }, range, field),
                make("div", { className: "ends" }, make("span", {}, plain(p.min)), make("span", {}, plain(p.max)))) };
        });
        const showSliders = () => sliders.forEach((s, k) => {
            s.range.value = String(Math.round(1000 * unitOf(parameters[k], here[k])));
            s.range.ariaValueText = `${figure(here[k])}, ${parameters[k].words}`;
            if (document.activeElement !== s.field) s.field.value = plain(Number(here[k].toPrecision(4)));
        });
        // axes: which parameters were moved; empty: all.
        const go = (at, axes = []) => {
            here = at;
            full = null;
            showSliders();
            update();
            const pair = pairs.length ? pairs[Number(pairField.value)] : [];
            if (axes.length === 0 || axes.some((k) => !pair.includes(k))) { if (!fittedField.checked) landscapeSoon(); }
        };
        const follow = make("input", { type: "checkbox", checked: true });
        const refit = latest(async () => {
            if (!changes()) {
                lowest = { ...first, values: home.values, outputs: home.outputs };
            } else {
                const answer = await ask("fit", { ...place(), at: (lowest || first).at.map(exact).join(",") });
                if (!answer || answer.status !== "converged") return;
                lowest = { ...answer.minimum, values: answer.point.values, outputs: answer.point.outputs };
            }
            sayMoved();
            if (pairs.length) drawLandscape();
            if (follow.checked) go(lowest.at.slice());
            else update();
            landscapeSoon();
        });
        let moving = Promise.resolve(); // kept when the fit that moves the sliders has ended
        const take = (i, value) => {
            if (!Number.isFinite(value)) return;
            taken[i] = value;
            cells[i].field.value = plain(value);
            full = null;
            moving = refit();
        };
        const fitHere = latest(async () => {
            const answer = await ask("fit", place());
            if (answer && answer.status === "converged") go(answer.minimum.at);
        });
        const confirmButton = make("button", { type: "button", className: "main" }, "confirm by the full model");
        const confirmed = make("p", { className: "soft", role: "status" });
        confirmButton.addEventListener("click", async () => {
            confirmButton.disabled = true;
            confirmed.textContent = "The full model runs ...";
            await moving;
            const answer = await ask("confirm", place());
            confirmButton.disabled = false;
            confirmed.textContent = "";
            if (!answer) return;
            if (answer.status !== "converged") {
                confirmed.textContent = `The full model has no answer here: ${answer.reason}`;
                return;
            }
            if (answer.at.every((v, k) => Math.abs(v - here[k]) <= 1e-9 * Math.abs(v))) {
                full = answer;
                const differences = readings.map((_, i) => (point.values[i] === null ? 0 : Math.abs(answer.values[i] / point.values[i] - 1)));
                confirmed.textContent = `Full model: χ² = ${figure(answer.chi2)} (here ${figure(point.chi2)}); readings differ by at most ${(100 * Math.max(...differences)).toFixed(2)} %; ${answer.seconds.toPrecision(2)} s.`;
                fill();
                drawReadings();
            } else {
                confirmed.textContent = "The sliders moved while the full model ran: press again for where they stand now.";
            }
        });
        const button = (text, action, more = {}) => {
            const made = make("button", { type: "button", ...more }, text);
            made.addEventListener("click", action);
            return made;
        };

        // -- the page ---------------------------------------------------------------------------------------------

        document.title = `${state.study.title} – explore`;
        const header = (names) => make("thead", {}, make("tr", {}, names.map((n) => make("th", {}, n))));
        root.append(make("header", {}, make("h1", {}, state.study.title), make("p", { className: "soft" }, state.model_words + (state.noise.stated && !state.noise.widened ? ""
            : state.noise.widened ? " The stated noise does not explain the misfit: what is left in the landscape counts with an error as large as the residuals of the best fit." : " The noise is not stated: χ² counts in the residuals of the best fit."))), trouble, sentence,
            make("div", { className: "panes" },
                make("section", { className: "hands" }, make("h2", {}, "Parameters"), sliders.map((s) => s.box),
                    make("div", { className: "choices" }, state.minima.slice(0, 6).map((m, k) => button(state.minima.length > 1 ? `minimum ${k + 1} (χ² ${figure(m.chi2)})` : "to the minimum", () => go(m.at.slice()))),
                        button("fit from here", () => { moving = fitHere(); }), button("study's values", () => go(parameters.map((p) => within(p, p.start))))),
                    make("div", { className: "choices" }, confirmButton), confirmed),
                make("div", { className: "work" },
                    make("div", { className: "two" },
                        make("section", {}, make("h2", {}, "Readings"), groups.map((g) => make("figure", {}, g.place)),
                            make("p", { className: "soft" }, `${readings.some((r) => r.sigma !== null) ? "Bars: one standard deviation. " : ""}Between the sensors the curve is the full model's at the minimum, scaled, and bent by a cubic to what the model reads at them; a confirmed curve is the full model's own. Drag a measured point, or change it below: the parameters are fitted again.`)),
                        pairs.length ? make("section", {}, make("h2", {}, "Landscape"), make("div", { className: "choices" }, pairField, make("label", {}, fittedField, " others fitted"), computeButton),
                            make("figure", {}, make("div", { className: "marked" }, landscapePlace, mark), landscapeNote)) : null),
                    outputs.length ? [make("h2", {}, "Outputs"), make("div", { className: "wide" }, make("table", {}, header(["output", "here", "minimum", "full model", "unit"]),
                        make("tbody", {}, outputs.map((o, i) => make("tr", {}, make("td", { className: "words" }, o.name), outputCells[i].now, outputCells[i].best, outputCells[i].byFull, make("td", {}, o.unit)))))), beyond] : [],
                    make("h2", {}, "What if a sensor read something else?"),
                    make("div", { className: "choices" }, make("label", {}, follow, " sliders follow the minimum"), button("all as measured", () => { readings.forEach((r, i) => { taken[i] = r.measured; cells[i].field.value = plain(r.measured); }); moving = refit(); })),
                    make("div", { className: "wide" }, make("table", { className: "readings" }, header(["reading", "taken to be", "", "unit", "model", "off (sd)", "full model"]), make("tbody", {}, cells.map((c) => c.row)))), moved)));
        let home = { values: readings.map(() => null), outputs: outputs.map(() => null) };
        showSliders();
        groups.forEach(draggable);
        ask("evaluate", place()).then((answer) => {
            if (!answer) return;
            home = answer;
            refit();
        });
        document.documentElement.dataset.ready = "yes";
    };
    ask("state").then((state) => { if (state) begin(state); });
})();
