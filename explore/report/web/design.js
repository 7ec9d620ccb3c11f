// The life that is left and the overlay: the summary, the picture beside it, and the section of `design`.
"use strict";
const designs = (() => {
    const { colours, make, figure, part, table, chart, axis } = blocks;
    const { say } = wording;

    const known = (v) => typeof v === "number" && Number.isFinite(v);
    const name = (criterion) => criterion.name.replaceAll("_", " ");
    // Longer than this is as good as for ever.
    const longest = 200;
    const years = (v) => (!known(v) ? "–" : v > longest ? `> ${longest}` : v < 10 ? v.toPrecision(2) : v.toFixed(0));
    const millimetres = (v, most) => (known(v) ? Math.ceil(v).toFixed(0) : `> ${most}`);
    const range = (low, high, words) => (words(low) === words(high) ? words(low) : `${words(low)} to ${words(high)}`);
    const wideRange = (c) => (c.if_wrong && (known(c.if_wrong.low) || known(c.if_wrong.high)) ? range(c.if_wrong.low, c.if_wrong.high, years) : "not bounded");
    const governing = (r) => [...r.criteria].sort((a, b) => (r.governs[b.name] || 0) - (r.governs[a.name] || 0))[0];

    const summaryOf = (r) => {
        const first = governing(r);
        const o = r.overlay_mm;
        const mm = (v) => millimetres(v, o.tried_up_to);
        const decides = (r.findings || []).find((s) => s.startsWith("What would decide: "));
        return { verdict: say(r.findings[0]), numbers: [
            { name: `years left: ${name(first)}`, value: years(first.remaining_years), range: range(first.low, first.high, years), unit: "years" },
            { name: "the same, if the model lacks something", value: "", range: wideRange(first), unit: "years" },
            { name: `overlay of ${o.layer}`, value: mm(o.value), range: range(o.low, o.high, mm), unit: "mm" }],
        action: decides ? `Measure next: ${say(decides.slice("What would decide: ".length))}` : say(r.findings[1] || "") };
    };

    // The years of each criterion with their ranges on one axis; the wide range if the model may lack something behind them.
    const picture = (r) => {
        const rows = r.criteria.filter((c) => known(c.remaining_years));
        if (rows.length === 0) return null;
        const shortest = 0.1;
        const at = (v) => Math.min(longest, Math.max(shortest, known(v) ? v : longest));
        const names = rows.map(name);
        const line = (of, width, color, words) => ({ type: "scatter", mode: "lines", name: words, hoverinfo: "skip", line: { width, color },
            x: rows.flatMap((c) => [at(of(c).low), at(of(c).high), null]), y: names.flatMap((n) => [n, n, null]) });
        return chart("lives", [line((c) => c.if_wrong || c, 5, "#c3ccd4", "95 %, if the model may lack something"), line((c) => c, 10, colours[0], "95 %, if the model is right"),
            { type: "scatter", mode: "markers", name: "best", x: rows.map((c) => at(c.remaining_years)), y: names, marker: { size: 11, color: "#fff", line: { color: "#000", width: 2 } },
                text: rows.map((c) => `${name(c)}: ${years(c.remaining_years)} years, ${range(c.low, c.high, years)}`), hoverinfo: "text" }],
        { xaxis: axis("years left", { type: "log", range: [Math.log10(shortest), Math.log10(1.6 * longest)], tickvals: [0.1, 1, 10, longest], ticktext: ["0.1", "1", "10", `> ${longest}`], tickangle: 0 }),
            yaxis: axis("", { automargin: true, autorange: "reversed", type: "category" }), height: 220 + 34 * rows.length, margin: { l: 64, r: 40, t: 24, b: 110 },
            legend: { orientation: "h", y: -90 / (86 + 34 * rows.length) } });
    };

    const show = (section, r, opening) => section("Life that is left", opening,
        part("Criteria", true), table(["criterion", "microstrain (95 %)", "years left (95 %)", "if the model lacks something", "ends first"], r.criteria.map((c) => [name(c),
            `${figure(c.strain_microstrain)} (${range(c.strain_low, c.strain_high, figure)})`, `${years(c.remaining_years)} (${range(c.low, c.high, years)})`,
            wideRange(c),
            known(r.governs[c.name]) ? `${Math.round(100 * r.governs[c.name])} %` : "–"]), [0]),
        make("p", { className: "soft" }, r.criteria.map((c) => `${name(c)}: ${c.formula}`).join("; ") + "."),
        (r.next || []).length ? [part("Further readings and cores, the most telling first"), table(["", "leaves of the range", "saves [mm]"],
            r.next.map((n) => [say(n.what), `${Math.round(100 * n.left)} %`, known(n.overlay_saved_mm) ? n.overlay_saved_mm.toFixed(0) : "–"]), [0])] : [],
        (r.seasons || []).length ? [part("Seasons"), table(["season", "share of the year", "factors on the stiffness"], r.seasons.map((s) => [s.name, figure(s.share),
            Object.entries(s.factors).filter(([, f]) => f !== 1).map(([layer, f]) => `${layer} ${figure(f)}`).join(", ")]), [0, 2])] : [],
        make("p", { className: "soft" }, "Years: of the traffic that the study states, from now. Strains are those at the place of each criterion under the design load."));

    return { summaryOf, picture, show };
})();
