// The page of a road: which stations are weak and which are not to be trusted, a map, strips, tables.
"use strict";
const roads = (() => {
    const { colours, symbols, make, figure, plain, part, words, table, chart, axis } = blocks;
    const { titled, unit, say } = wording;
    const red = "#c1121f";
    const amber = "#E69F00";
    const mostNamed = 12; // stations, before the rest is folded

    // Stations of one profile and lane: they follow each other along the road, others do not.
    const lanesOf = (stations) => {
        const lanes = new Map();
        for (const s of stations) {
            const name = [s.profile, s.lane && `lane ${s.lane}`].filter(Boolean).join(", ");
            lanes.set(name, [...(lanes.get(name) || []), s]);
        }
        return [...lanes].map(([name, list]) => ({ name: name || "the road", stations: list }));
    };
    const quantileOf = (values, q) => {
        const sorted = [...values].sort((a, b) => a - b);
        const at = q * (sorted.length - 1);
        return sorted[Math.floor(at)] + (at % 1) * (sorted[Math.ceil(at)] - sorted[Math.floor(at)]);
    };
    const medianOf = (values) => quantileOf(values, 0.5);
    // Stations worth a visit: {station, kind: "weak", "fails" or "none", why}, the worst first. The program says which are weak.
    const notable = (r) => {
        const beside = (v) => `${(100 * Math.abs(v - 1)).toFixed(0)} % ${v < 1 ? "below" : "above"} the median`; // as in the terminal
        const weak = (r.weak_stations || []).map((w) => {
            const station = r.stations[w.station];
            const name = w.parameter ? `${wording.parameter(w.parameter).name} ` : "";
            return { station, kind: "weak", why: [`deflection ${figure(station.D0_um_at_common_pressure)} µm, ${beside(w.times_median)} of its section`, ...(w.parameter ? [`${name}${beside(w.parameter_times_median)}`] : [])] };
        });
        const others = r.stations.filter((s) => !weak.some((w) => w.station === s));
        const none = (s) => s.D0_um === undefined || (s.status !== "ok" && s.reason);
        return [...weak,
            ...others.filter((s) => !none(s) && s.pass === false).map((station) => ({ station, kind: "fails", why: [`deflection ratio ${figure(station.deflection_ratio)}, below ${plain(r.deflection_ratio.limit)}`] })),
            ...others.filter(none).map((station) => ({ station, kind: "none", why: [station.reason || "no result"] }))];
    };
    // Where a station is; within one lane of one road the chainage says it.
    const chainageOf = (s) => (typeof s.chainage_m === "number" ? `${plain(s.chainage_m)} m` : "");
    const placeOf = (s) => [s.profile, s.lane && `lane ${s.lane}`, chainageOf(s)].filter(Boolean).join(", ");
    const namesOf = (r) => {
        const place = lanesOf(r.stations).length > 1 ? placeOf : chainageOf;
        return (n) => `${n.station.station}${place(n.station) ? ` (${place(n.station).replace(/ m$/, "\u00a0m")})` : ""}`;
    };
    const kinds = { weak: "weak", fails: "fails", none: "not to be trusted" };
    const markOf = (notables) => {
        const of = new Map(notables.map((n) => [n.station, n.kind]));
        return (s, colour) => ({ weak: red, fails: amber, none: "#777" }[of.get(s)] || colour);
    };

    const summaryOf = (r) => {
        const found = notable(r);
        const named = namesOf(r);
        const of = (kind) => found.filter((n) => n.kind === kind);
        const [weak, fails, none] = [of("weak"), of("fails"), of("none")];
        const count = (list, one, many) => (list.length ? `${list.length} ${list.length === 1 ? one : many}` : "");
        const outliers = (r.outliers || []).map((o) => `${o.station}${typeof o.chainage_m === "number" ? ` (${plain(o.chainage_m)}\u00a0m)` : ""}`);
        const doubts = r.better_layout ? "sensors may stand elsewhere than the file says" : r.suspect_sensor ? `the sensor at ${plain(r.suspect_sensor.offset_mm)} mm is in question`
            : r.section_is_suspect ? "the model is off with one sign along the road: the section is in question" : "";
        const rest = [doubts, outliers.length > 3 ? `${outliers.length} stations do not belong to the road` : outliers.length ? `${outliers.join(", ")} ${outliers.length === 1 ? "does" : "do"} not belong to the road` : "",
            count(fails, "station fails the deflection ratio", "stations fail the deflection ratio"), count(none, "station has no result or a doubtful one", "stations have no result or a doubtful one")].filter(Boolean).join("; ");
        const verdict = (!r.weak_stations ? `${r.counts.stations} ${r.counts.stations === 1 ? "station" : "stations"}, too few to say which are weak`
            : weak.length === 0 ? `No station of ${r.counts.stations} is weak beside its section`
            : weak.length === 1 ? `${named(weak[0])} is weak: ${weak[0].why.join("; ")}`
            : `${weak.length} of ${r.counts.stations} stations are weak, most of all ${named(weak[0])}: ${weak[0].why[0]}`) + (rest ? `. ${rest[0].toUpperCase()}${rest.slice(1)}.` : ".");
        const good = r.stations.filter((s) => s.D0_um !== undefined);
        const spread = (name, values, of) => (values.length ? [{ name, value: figure(medianOf(values)), range: `${figure(quantileOf(values, 0.15))} to ${figure(quantileOf(values, 0.85))}`, unit: of }] : []);
        const names = [...new Set(good.flatMap((s) => Object.keys(s.parameters || {})))];
        const least = names.filter((n) => n.endsWith("_MPa")).reverse().slice(0, 2); // the lowest layers
        const numbers = [...spread(`deflection at ${plain(r.common_pressure_kPa)} kPa`, good.map((s) => s.D0_um_at_common_pressure).filter((v) => typeof v === "number"), "µm"),
            ...least.flatMap((n) => spread(wording.parameter(n).name, good.map((s) => s.parameters && s.parameters[n] && s.parameters[n].determined ? s.parameters[n].value : null).filter((v) => v !== null), wording.parameter(n).unit))];
        const action = weak.length ? `Look at ${named(weak[0])} first: repeat the drops there, then core it and look at its drainage${weak.length > 1 ? `, then at the other ${weak.length - 1} below` : ""}; elsewhere use the percentiles of the sections.`
            : fails.length ? `Look at ${named(fails[0])} first.` : "Use the percentiles of the sections.";
        if (r.shared) { // a road as one experiment
            const outliers = r.outliers || [];
            return { verdict: say(r.answer), named: null, value: "value", numbers: [...r.shared, ...r.section_parameters].map((p) => ({ name: wording.parameter(p.name).name + (p.level === "section" ? `, section ${p.section + 1}` : ""),
                value: figure(p.value), range: p.determined ? `${figure(p.low)} to ${figure(p.high)}` : "not determined", unit: wording.parameter(p.name).unit })),
            action: outliers.length && weak.length === 0 ? `Look at ${outliers.slice(0, 3).map((o) => o.station).join(", ")}${outliers.length > 3 ? ` and ${outliers.length - 3} more` : ""}: ${say(outliers[0].reason)}.` : action };
        }
        const list = weak.length > 1 ? weak : weak.length === 0 && fails.length <= mostNamed ? fails : [];
        const more = list.length > mostNamed ? ` and ${list.length - mostNamed} more below` : "";
        return { verdict, named: list.length ? [list === weak ? "Weak: " : "Fails the ratio: ", `${list.slice(0, mostNamed).map(named).join(", ")}${more}.`] : null, numbers, action, range: "15 to 85 % of the stations", value: "median" };
    };

    // Places along a lane in order, with a break where stations are missing: beyond five times the usual distance and half a kilometre.
    const brokenWay = (list, valueOf) => {
        const steps = list.slice(1).map((s, i) => Math.abs(s.chainage_m - list[i].chainage_m)).filter((d) => d > 0);
        const most = steps.length ? Math.max(500, 5 * medianOf(steps)) : Infinity;
        return list.flatMap((s, i) => (i > 0 && Math.abs(s.chainage_m - list[i - 1].chainage_m) > most ? [{ x: null, y: null, s: null }] : []).concat([{ x: s.chainage_m, y: valueOf(s), s }]));
    };
    // One trace a lane along the road; what the readings do not determine is open; a level line is the median of a homogeneous section.
    const strip = (r, stations, title, valueOf, { caption = null, rangeOf = () => null, determined = () => true, more = {}, shapes = [], colourOf = (_, c) => c, onClick = null } = {}) => {
        const lanes = lanesOf(stations);
        const traces = lanes.flatMap(({ name, stations: list }, k) => {
            const colour = colours[k % colours.length];
            const way = brokenWay(list, valueOf);
            const ranges = way.map(({ s }) => (s && determined(s) ? rangeOf(s) : null));
            const parts = (r.sections || []).filter((p) => (p.profile || "") === (list[0].profile || "") && (p.lane || "") === (list[0].lane || ""));
            const levels = parts.map((p) => {
                const values = list.filter((s) => s.chainage_m >= p.from_m && s.chainage_m <= p.to_m && determined(s)).map(valueOf).filter((v) => v !== null && v !== undefined);
                const level = way.filter(({ s }) => !s || (s.chainage_m >= p.from_m && s.chainage_m <= p.to_m));
                return values.length ? { type: "scatter", mode: "lines", x: level.map((w) => w.x), y: level.map(({ s }) => (s ? medianOf(values) : null)), showlegend: false, connectgaps: false,
                    hoverinfo: "skip", line: { width: 3, color: colour }, opacity: 0.35 } : null;
            }).filter(Boolean);
            const marks = way.map(({ s }) => (s ? colourOf(s, colour) : colour));
            return [{ type: "scatter", mode: "lines+markers", name, showlegend: lanes.length > 1, x: way.map((w) => w.x), y: way.map((w) => w.y), customdata: way.map(({ s }) => (s ? r.stations.indexOf(s) : -1)),
                text: way.map(({ s }) => (s ? `${s.station}, ${placeOf(s)}` : "")), line: { width: 1, color: colour }, connectgaps: false,
                marker: { size: marks.map((c) => (c === red ? 11 : list.length > 150 ? 5 : c === amber ? 9 : 7)), color: marks, symbol: way.map(({ s }) => symbols[k % symbols.length] + (!s || determined(s) ? "" : "-open")) },
                error_y: ranges.some((range) => range) ? { type: "data", symmetric: false, thickness: 1, width: list.length > 150 ? 0 : 2,
                    array: way.map((w, i) => (ranges[i] ? ranges[i][1] - w.y : 0)), arrayminus: way.map((w, i) => (ranges[i] ? w.y - ranges[i][0] : 0)) } : undefined }, ...levels];
        });
        return chart("strip", traces, { xaxis: axis("chainage [m]"), yaxis: axis(title, more), height: lanes.length > 1 ? 320 : 260, shapes }, caption, onClick);
    };

    // The bowl of the station that was clicked.
    const bowlOf = (r) => (index) => {
        const s = r.stations[index];
        const place = document.querySelector(".bowl");
        if (!s || !place || !(s.readings || []).length) return;
        const of = (key) => ({ x: s.readings.map((q) => q.offset_mm), y: s.readings.map((q) => q[key]) });
        place.textContent = "";
        place.append(chart("bowl", [{ type: "scatter", mode: "markers", name: "measured", ...of("measured_um"), marker: { size: 9, color: "#000" } },
            ...(typeof s.readings[0].model_um === "number" ? [{ type: "scatter", mode: "lines+markers", name: "model", ...of("model_um"), line: { color: colours[0] }, marker: { size: 5, symbol: "square" } }] : [])],
        { title: { text: `Station ${s.station}, ${placeOf(s)}` }, xaxis: axis("distance from the load [mm]"), yaxis: axis("deflection [µm]", { autorange: "reversed" }), height: 340 }));
        blocks.pending.pop()();
        if (place.closest("details")) place.closest("details").open = true;
        place.scrollIntoView({ block: "nearest" });
    };
    const deflections = (r) => {
        const notables = notable(r);
        return strip(r, r.stations.filter((s) => s.D0_um !== undefined), `D0 at ${plain(r.common_pressure_kPa)} kPa [µm]`, (s) => s.D0_um_at_common_pressure,
            { more: { rangemode: "tozero" }, colourOf: markOf(notables), onClick: bowlOf(r), caption: ((r.sections || []).length ? "Level lines: the medians of homogeneous sections. " : "") +
                (notables.some((n) => n.kind === "weak") ? "Red: weak. " : "") + (notables.some((n) => n.kind === "fails") ? "Amber: fails the deflection ratio. " : "") + "A click on a station shows its bowl." });
    };
    const positions = (r) => r.stations.filter((s) => typeof s.latitude === "number" && typeof s.longitude === "number");
    // The picture beside the summary: the map, or without positions the deflections along the road.
    const picture = (r) => (positions(r).length > 1 ? map(r, notable(r), bowlOf(r)) : deflections(r));

    // Positions in kilometres from their middle, by the colour of the deflection.
    const map = (r, notables, onClick) => {
        const there = positions(r);
        const [lat, lon] = [medianOf(there.map((s) => s.latitude)), medianOf(there.map((s) => s.longitude))];
        const east = (s) => (s.longitude - lon) * 111.32 * Math.cos(lat * Math.PI / 180);
        const north = (s) => (s.latitude - lat) * 111.32;
        const at = (list, more) => ({ type: "scatter", mode: "markers", x: list.map(east), y: list.map(north), text: list.map((s) => `${s.station}, ${placeOf(s)}${s.D0_um === undefined ? "" : `: ${figure(s.D0_um_at_common_pressure)} µm`}`),
            hoverinfo: "text", customdata: list.map((s) => r.stations.indexOf(s)), ...more });
        const good = there.filter((s) => s.D0_um !== undefined);
        const values = good.map((s) => s.D0_um_at_common_pressure);
        const marked = (kind) => notables.filter((n) => n.kind === kind && there.includes(n.station)).map((n) => n.station);
        const failing = marked("fails");
        const weak = marked("weak");
        const few = weak.length <= 6;
        return chart("map", [
            at(good, { name: "stations", showlegend: false, marker: { size: 7, color: values, colorscale: "Cividis", reversescale: true, colorbar: { title: { text: "deflection<br>[µm]" }, thickness: 10 } } }),
            at(marked("none"), { name: kinds.none, marker: { size: 9, symbol: "x", color: "#777" } }),
            at(failing, { name: "fails the ratio", marker: { size: failing.length > good.length / 3 ? 7 : 12, symbol: "square-open", color: amber, line: { width: failing.length > good.length / 3 ? 1 : 3 } } }),
            { ...at(weak, { name: "weak", marker: { size: 15, symbol: "circle-open", color: red, line: { width: 3 } } }), ...(few ? { mode: "markers+text", texttemplate: weak.map((s) => s.station), textposition: weak.map((s) => (weak.filter((w) => east(w) < east(s)).length % 2 ? "bottom center" : "top center")), textfont: { color: red } } : {}) },
        ].filter((t) => t.x.length), { xaxis: axis("east [km]"), yaxis: axis("north [km]", { scaleanchor: "x", scaleratio: 1 }), height: 380, margin: { l: 56, r: 8, t: 30, b: 80 }, legend: { orientation: "h", y: -0.22 } },
        "The stations where they lie, from their positions; north is up.", onClick);
    };

    // Residuals of every sensor: over all stations, and along the road.
    const residualsPart = (r, fitted) => {
        const signed = (v) => `${v > 0 ? "+" : ""}${v.toFixed(1)}`;
        const rows = (list, place) => list.map((q) => [place(q), signed(q.model_percent), q.scatter_percent.toFixed(1), `${q.above} of ${q.stations}${q.one_sign ? ", one sign" : ""}`]);
        const heads = (first) => [first, "model over reading [%]", "scatter [%]", "model above at"];
        const sensors = r.sensor_residuals || [];
        const loads = r.load_residuals || [];
        if (!sensors.length) return [];
        const lanes = lanesOf(fitted);
        const traces = sensors.map(({ offset_mm: offset }, k) => {
            const share = (s) => {
                const q = s && (s.readings || []).find((one) => one.offset_mm === offset);
                return q && q.model_um > 0 && q.measured_um > 0 ? Number((100 * (q.model_um / q.measured_um - 1)).toFixed(2)) : null;
            };
            const way = lanes.flatMap(({ stations }, i) => [...(i ? [{ x: null, y: null }] : []), ...brokenWay(stations, share)]);
            return { type: "scatter", mode: "lines", name: `${plain(offset)} mm`, x: way.map((w) => w.x), y: way.map((w) => w.y), connectgaps: false, line: { width: 1, color: colours[k % colours.length], dash: k < colours.length ? "solid" : "dot" } };
        });
        return [part("Residuals of the sensors"), make("p", { className: "soft" }, "Medians over the stations. A wave over all sensors is the section's; one sensor with a sign of its own is the sensor's."),
            table(heads("sensor [mm]"), rows(sensors, (q) => q.offset_mm), [3]),
            chart("residual-strip", traces, { xaxis: axis("chainage [m]"), yaxis: axis("model over reading [%]"), height: 340 }),
            loads.length > 1 ? table(heads("load [kPa]"), rows(loads, (q) => q.pressure_kPa), [3]) : []];
    };
    // The modulus that a half-space would have by each sensor: it looks as deep as the sensor is far away.
    const surfaceModuli = (good) => {
        const some = good.filter((s) => s.normalised && s.normalised.surface_moduli.length > 1);
        if (!some.length) return [];
        const offsets = some[0].normalised.surface_moduli.map((m) => m.offset_mm);
        const at = (o) => some.map((s) => s.normalised.surface_moduli.find((m) => m.offset_mm === o)).filter(Boolean).map((m) => m.modulus_MPa);
        const line = (q, name, style) => ({ type: "scatter", mode: "lines+markers", name, x: offsets.map((o) => quantileOf(at(o), q)), y: offsets, line: { color: colours[0], ...style } });
        return [part("Surface modulus over depth"), chart("surface-modulus", [line(0.15, "15 %", { dash: "dot", width: 1 }), line(0.5, "median", { width: 2 }), line(0.85, "85 %", { dash: "dot", width: 1 })],
            { xaxis: axis("surface modulus [MPa]"), yaxis: axis("depth [mm]", { autorange: "reversed" }), height: 340 }, "Depth: the distance of the sensor, which looks about as deep. A subgrade that stiffens with depth, or under less stress, bends the line to the right at its lower end.")];
    };
    // The worst class of a station for one kind of base.
    const classes = ["sound", "warning", "severe"];
    const worstOf = (s, kind) => {
        const found = Object.values((s.condition || {})[kind] || {}).map((c) => classes.indexOf(c)).filter((c) => c >= 0);
        return found.length ? classes[Math.max(...found)] : null;
    };

    const showSurvey = (section, r, said) => {
        const good = r.stations.filter((s) => s.D0_um !== undefined);
        const fitted = good.filter((s) => s.fit);
        const common = new Set((r.shared || []).map((p) => p.name)); // alike at all stations
        const names = fitted.length ? Object.keys(fitted[0].fit.parameters).filter((n) => !common.has(n)) : [];
        const outputs = [...new Set(fitted.flatMap((s) => Object.keys(s.outputs || {})))];
        const known = (s, n) => !s.parameters || !s.parameters[n] || s.parameters[n].determined;
        const withRange = (p) => (!p ? null : p.determined ? `${figure(p.value)} (${figure(p.low)} to ${figure(p.high)})` : `${figure(p.value)} (?)`);
        const source = (s) => (s.file ? `${s.file.split("/").pop()}, line ${s.line}` : "");
        // Columns that hold something, so that a table fits the page; long names may break.
        const list = (title, stations, columns, left = []) => {
            const shown = [["station", (s) => s.station], ["profile", (s) => s.profile], ["lane", (s) => s.lane], ["chainage [m]", (s) => s.chainage_m], ...columns]
                .filter(([, of], i) => i === 0 || stations.some((s) => ![null, undefined, ""].includes(of(s))));
            return shown.length < 3 || stations.length === 0 ? [] : [part(title), make("div", { className: "narrow" },
                table(shown.map(([n]) => n.replace(/([._])/g, "$1\u200b")), stations.map((s) => shown.map(([, of]) => of(s))),
                    shown.map(([n], i) => (left.includes(n) ? i : -1)).filter((i) => i >= 0)))];
        };
        const remarked = r.stations.filter((s) => (s.remarks || []).length);
        const percentiles = (p) => (p ? `${figure(p.p15)} / ${figure(p.p50)} / ${figure(p.p85)}` : null);
        // Of a parameter: of the stations that determine it.
        const determinedOnly = (p, fitted) => (!fitted ? percentiles(p) : !p ? `? (0 of ${fitted})` : p.stations < fitted ? `${percentiles(p)} (${p.stations} of ${fitted})` : percentiles(p));
        const notables = notable(r);
        const colourOf = markOf(notables);
        const where = (n) => [n.station.station, n.station.chainage_m, kinds[n.kind], n.why.join("; "), source(n.station)];
        const notableTable = (some) => make("div", { className: "plain" }, table(["station", "chainage [m]", "", "why", "where"], some.map(where), [2, 3, 4]));
        const along = (stations, title, valueOf, more = {}) => strip(r, stations, title, valueOf, { colourOf, onClick: bowlOf(r), ...more });
        const headed = (title, list) => {
            const charts = list.map(([name, of]) => [name, of, r.stations.filter((s) => typeof of(s) === "number")]).filter(([, , some]) => some.length).map(([name, of, some]) => along(some, name, of));
            return charts.length ? [part(title), charts] : [];
        };
        section("The road", make("p", {}, `${r.counts.stations} stations, ${r.counts.rejected} rejected${r.counts.no_ratio ? `, ${r.counts.no_ratio} without a deflection ratio` : ""}` +
            (r.counts.fitted ? `, ${r.counts.fitted} back-calculated, ${r.counts.no_fit || 0} not described by the model, ${r.counts.failed} without an answer.` : ".")),
        notables.length ? notableTable(notables.slice(0, mostNamed)) : [],
        fitted.some((s) => s.lives) ? [part("Life along the road", true), along(fitted.filter((s) => s.lives && s.lives.years > 0), "years left", (s) => s.lives.years,
            { more: { type: "log" }, rangeOf: (s) => (s.lives.years_low > 0 && s.lives.years_high ? [s.lives.years_low, s.lives.years_high] : null),
                caption: "At the best fits, of the criterion that ends first, with 95 % ranges." })] : [],
        good.length ? [part("Deflections along the road", true), positions(r).length > 1 ? deflections(r) : null, make("div", { className: "bowl" }),
        along(good, "deflection ratio", (s) => s.deflection_ratio, { caption: r.deflection_ratio.definition, shapes: [{ type: "line", xref: "paper", x0: 0, x1: 1,
            y0: r.deflection_ratio.limit, y1: r.deflection_ratio.limit, line: { dash: "dash", color: colours[1] } }] })] : [],
        names.length ? part("What was back-calculated, along the road", true) : null,
        names.map((n) => along(fitted, titled(n), (s) => s.fit.parameters[n], { determined: (s) => known(s, n),
            rangeOf: (s) => (s.parameters && s.parameters[n] ? [s.parameters[n].low, s.parameters[n].high] : null),
            caption: fitted.every((s) => known(s, n)) ? null : "Open: not determined by these readings, not to be used." })),
        outputs.map((n) => along(fitted.filter((s) => s.outputs && s.outputs[n]), `${n} [${unit(outputUnit(fitted, n))}]`, (s) => s.outputs[n].value,
            { determined: (s) => s.outputs[n].determined, rangeOf: (s) => [s.outputs[n].low, s.outputs[n].high] })),
        fitted.length ? rmsBars(fitted) : [],
        headed("Temperatures along the road", [["surface [°C]", (s) => s.surface_C], ["air [°C]", (s) => s.air_C], ["asphalt [°C]", (s) => s.asphalt_C]]),
        headed("Indices along the road", [["SCI [µm]", "SCI_um"], ["BDI [µm]", "BDI_um"], ["BCI [µm]", "BCI_um"], ["AREA [mm]", "AREA_mm"]].map(([title, key]) => [title, (s) => (s.normalised ? s.normalised[key] : null)])),
        typeof r.reference_C === "number" ? headed(`Deflections and indices at ${plain(r.reference_C)} °C`, atReference(r)) : [],
        residualsPart(r, fitted),
        surfaceModuli(good),
        said.length ? [part("Findings"), words(said.map(say))] : [],
        notables.length > mostNamed ? [part(`The other ${notables.length - mostNamed} stations to look at`), notableTable(notables.slice(mostNamed))] : [],
        (r.sections || []).length && r.sections[0].D0_um ? [part("Homogeneous sections"), make("p", { className: "soft" }, "Cumulative differences of ln D0; 15 / 50 / 85 % of the stations do not exceed; of a parameter, of those that determine it."),
            sectionTable(r.sections, [["profile", (p) => p.profile], ["lane", (p) => p.lane], ["from [m]", (p) => p.from_m], ["to [m]", (p) => p.to_m], ["stations", (p) => p.stations],
                ["D0 [µm]", (p) => percentiles(p.D0_um)], ["characteristic D0 [µm]", (p) => (p.characteristic ? p.characteristic.D0_um : null)], ...names.map((n) => [titled(n), (p) => determinedOnly((p.parameters || {})[n], p.fitted)])])] : [],
        list("Stations", good, [["drops", (s) => (s.drops_used || []).join(" ")], ["pressure [kPa]", (s) => s.pressure_kPa], ["D0 [µm]", (s) => s.D0_um],
            ["deflection ratio", (s) => s.deflection_ratio], ["verdict", (s) => (s.pass === null || s.pass === undefined ? s.deflection_ratio_reason : s.pass ? "pass" : "fail")]], ["verdict"]),
        list("Parameters", fitted, [...names.map((n) => [titled(n), (s) => withRange((s.parameters || {})[n]) || figure(s.fit.parameters[n])]), ["rms [%]", (s) => s.fit.rms_percent]]),
        list("Outputs", outputs.length ? fitted : [], outputs.map((n) => [`${n} [${unit(outputUnit(fitted, n))}]`, (s) => withRange((s.outputs || {})[n])])),
        list(`Indices${good.length && good[0].normalised ? ` at ${plain(good[0].normalised.pressure_kPa)} kPa` : ""}`, good.filter((s) => s.normalised), [
            ["D0 [µm]", (s) => s.normalised.D0_um], ["SCI [µm]", (s) => s.normalised.SCI_um], ["BDI [µm]", (s) => s.normalised.BDI_um], ["BCI [µm]", (s) => s.normalised.BCI_um],
            ["AREA [mm]", (s) => s.normalised.AREA_mm], ["radius of curvature [m]", (s) => s.normalised.curvature_radius_m],
            ["E0 [MPa]", (s) => (s.normalised.surface_moduli[0] || {}).modulus_MPa], ["asphalt [°C]", (s) => s.asphalt_C], ...atReference(r),
            ["asphalt at reference [MPa]", (s) => s.asphalt_modulus_at_reference_MPa]]),
        list("Condition", good.filter((s) => s.structural_number || s.condition), [["SN_eff", (s) => (s.structural_number || {}).SN_eff], ["design subgrade [MPa]", (s) => (s.structural_number || {}).design_subgrade_MPa],
            ...["granular", "bituminous", "cemented"].map((kind) => [`${kind} base`, (s) => worstOf(s, kind)])], ["granular base", "bituminous base", "cemented base"]),
        list("When and where", r.stations, [["date", (s) => s.date], ["time", (s) => s.time], ["air [°C]", (s) => s.air_C], ["surface [°C]", (s) => s.surface_C],
            ["latitude", (s) => place(s.latitude)], ["longitude", (s) => place(s.longitude)], ["operator", (s) => s.comment], ["source", source]], ["operator", "source"]),
        list("Remarks", remarked, [["remarks", (s) => s.remarks.join("; ")]], ["remarks"]));
    };
    const sectionTable = (sections, columns) => {
        const shown = columns.filter(([, of]) => sections.some((p) => ![null, undefined, ""].includes(of(p))));
        return make("div", { className: "narrow" }, table(shown.map(([n]) => n.replace(/([._])/g, "$1\u200b")), sections.map((p) => shown.map(([, of]) => of(p)))));
    };
    const atReference = (r) => (typeof r.reference_C !== "number" ? [] : ["D0", "SCI", "BDI", "BCI"].map((name) => [`${name} at ${plain(r.reference_C)} °C [µm]`, (s) => (s.at_reference ? s.at_reference[`${name}_um`] : null)]));
    const place = (degrees) => (degrees === null || degrees === undefined ? null : degrees.toFixed(6));
    const outputUnit = (stations, n) => stations.map((s) => (s.outputs || {})[n]).find((o) => o).unit;
    const rmsBars = (fitted) => {
        const lanes = lanesOf(fitted);
        return chart("strip", lanes.map(({ name, stations }, k) => ({ type: "bar", name, x: stations.map((s) => s.chainage_m), y: stations.map((s) => s.fit.rms_percent),
            text: stations.map((s) => s.station), textposition: "none", marker: { color: colours[k % colours.length] } })),
        { xaxis: axis("chainage [m]"), yaxis: axis("rms of the fit [%]"), height: lanes.length > 1 ? 300 : 220, barmode: "group", showlegend: lanes.length > 1 });
    };

    // Pairs of what the road has in common: the stations each by itself, and the road.
    const materialCharts = (r) => {
        const alone = r.stations.filter((s) => s.road && !s.road.outlier);
        const value = (n) => r.shared.find((p) => p.name === n).value;
        return r.landscape.length === 0 ? [] : [part("The material's landscape"), make("div", { className: "charts" }, r.landscape.map((l) => chart("material", [
            { type: "scatter", mode: "markers", name: "a station by itself", x: alone.map((s) => s.road.alone[l.x].value), y: alone.map((s) => s.road.alone[l.y].value),
                text: alone.map((s) => s.station), marker: { size: 6, color: "#9aa5ad" } },
            { type: "scatter", mode: "lines", name: "the road, 95 %", x: l.border.map((b) => b[0]), y: l.border.map((b) => b[1]), fill: "toself", line: { color: colours[0] } },
            { type: "scatter", mode: "markers", name: "the road", x: [value(l.x)], y: [value(l.y)], marker: { size: 8, symbol: "x", color: colours[1] } }],
        { xaxis: axis(titled(l.x), { type: l.log_x ? "log" : "linear" }), yaxis: axis(titled(l.y), { type: l.log_y ? "log" : "linear" }), height: 340 }))),
        make("p", { className: "soft" }, "To first order around the answer. Stations by themselves lie along what they cannot tell apart; one on the edge of a picture ended on a bound of its range.")];
    };

    const showRoad = (section, r, said) => {
        section("The road as one experiment", table(["", "value", "from", "to", "share of the allowed range [%]", "the same, median station alone [%]", "stations"],
            [...r.shared, ...r.section_parameters].map((p) => [p.level === "section" ? `${titled(p.name)}, section ${p.section + 1}` : titled(p.name), p.value, p.low,
                p.high, 100 * p.width, 100 * p.median_width_alone, p.stations])),
        said.length ? [part("Findings"), words(said.map(say))] : [],
        materialCharts(r),
        r.outliers.length ? [part("Stations that do not belong", true),
            table(["station", "chainage [m]", "why"], r.outliers.map((o) => [o.station, o.chainage_m, say(o.reason)]), [2])] : []);
        showSurvey(section, r, r.remarks);
    };

    return { summaryOf, showSurvey, showRoad, picture };
})();
