// The top of a page: a verdict in a sentence, at most three numbers with their ranges, what to do next.
"use strict";
const summaries = (() => {
    const { figure } = blocks;
    const { parameter, unit, say } = wording;

    // The wider range of an output where the model may be wrong; rejected: the model is, so that its own range is not shown.
    const widest = (o) => {
        const wide = o.if_wrong;
        return wide ? { low: Math.min(o.low ?? wide.low, wide.low), high: Math.max(o.high ?? wide.high, wide.high), wider: wide.low < o.low || wide.high > o.high }
            : { low: o.low, high: o.high, wider: false };
    };
    const rejected = (r) => {
        const p = r.acceptance ? r.acceptance.p_value : r.baseline ? r.baseline.p_value : r.p_value;
        return typeof p === "number" && p < 0.05;
    };
    const known = (v) => typeof v === "number" && Number.isFinite(v);
    const number = (name, value, low, high, of = "") => ({ name, value: known(value) ? figure(value) : "", range: known(low) && known(high) ? `${figure(low)} to ${figure(high)}` : "not determined", unit: unit(of || "") });
    const parameterNumber = (name, value, low, high) => {
        const { name: words, unit: of } = parameter(name);
        return number(words, value, low, high, of);
    };
    const outputNumber = (o, value) => number(o.name, value, widest(o).low, widest(o).high, o.unit);
    const byWidth = (list) => [...list].sort((a, b) => (a.high / a.low || Infinity) - (b.high / b.low || Infinity));

    const left = (share) => `${Math.round(100 * share)} %`;
    const measure = (c) => {
        if (!c || !c.reading) return null;
        const falls = Object.entries(c.outputs_after_over_before || {}).filter(([, v]) => known(v));
        const shares = Object.entries(c.standard_error_after_over_before || {}).filter(([, v]) => known(v)).sort((a, b) => a[1] - b[1]);
        const [what, share] = falls.sort((a, b) => a[1] - b[1])[0] || shares[0] || [];
        return `Measure next: ${say(c.reading)}.` + (what === undefined ? known(c.power) ? ` It tells the candidates apart in ${left(c.power)} of cases.` : ""
            : ` The standard error of ${parameter(what).name} would fall to ${left(share)} of what it is.`);
    };
    const first = (list) => (Array.isArray(list) ? list[0] : list);

    const of = {
        fit: (r) => {
            const best = (r.minima || [])[0] || { parameters: {} };
            const error = (n) => ((r.best || {}).std_error || {})[n]; // none: at a bound, or not determined
            const span = new Map((r.parameters || []).map((p) => [p.name, p]));
            const list = Object.entries(best.parameters).map(([n, v]) => {
                const range = (best.ranges_95 || {})[n];
                const p = span.get(n);
                if (range) return { n, v, low: range[0], high: range[1] };
                if (!known(error(n))) return { n, v };
                const reach = 1.96 * error(n); // on the scale of the parameter, within its bounds
                const [low, high] = p && p.scale === "log" ? [v * Math.exp(-reach / v), v * Math.exp(reach / v)] : [v - reach, v + reach];
                return { n, v, low: p ? Math.max(low, p.min) : low, high: p ? Math.min(high, p.max) : high };
            });
            return { numbers: byWidth(list).map((q) => parameterNumber(q.n, q.v, q.low, q.high)),
                action: `One best fit is not the only answer: pavescape unique ${(r.study || {}).file || "STUDY"} says which other values fit as well.` };
        },
        unique: (r) => ({ numbers: [...(r.outputs || []).map((o) => outputNumber(o, o.best)), ...byWidth(r.profiles || []).map((p) => parameterNumber(p.name, p.best, p.low, p.high))],
            action: rejected(r) ? `The data contradict the model: before any number is used, pavescape diagnose ${(r.study || {}).file || "STUDY"} looks for what it lacks.`
                : r.verdict === "unique" ? "Use the ranges, not the best values alone." : measure(first(r.next_measurement)) || "Use the ranges, not the best values." }),
        sample: (r) => ({ numbers: [...(r.outputs || []).map((o) => number(o.name, o.q50, o.q025, o.q975, o.unit)), ...(r.parameters || []).map((p) => parameterNumber(p.name, p.q50, p.q025, p.q975))],
            action: measure(first(r.next_measurement)) || "Use the ranges, not the medians alone." }),
        diagnose: (r) => ({ numbers: [...(r.outputs || []).map((o) => outputNumber(o, o.after ?? o.before)),
            ...byWidth(Object.entries((r.extended || r.baseline || {}).parameters || {}).map(([n, p]) => ({ n, ...p }))).map((p) => parameterNumber(p.n, p.value, p.low, p.high))],
        action: measure(r.next_measurement) || (r.verdict === "adequate" ? "Nothing speaks for another model: go on with the study's, and with the ranges given here."
            : "Use the wider ranges until another reading has settled the cause.") }),
        compare: (r) => {
            const good = (r.laws || r.studies || []).filter((l) => l.status === "converged");
            const top = [...good].sort((a, b) => (b.weight || 0) - (a.weight || 0))[0];
            return { numbers: top ? [...top.outputs.map((o) => outputNumber(o, o.best)), ...Object.entries(top.parameters).map(([n, p]) => parameterNumber(n, p.value, p.low, p.high))] : [],
                action: top ? `Go on with ${say(top.law || top.study)}${good.some((l) => l !== top && (l.weight || 0) > 0.1) ? ", and give the ranges of the others beside it: their weights are not small" : ""}.` : "" };
        },
        sensitivity: () => ({ numbers: [], action: "Measure where the curves of two parameters differ; leave out a parameter whose curves stay level." }),
        map: (r) => ({ numbers: [], action: `A point of a map is no best fit yet: pavescape fit ${(r.study || {}).file || "STUDY"} searches for that.` }),
    };

    // The sentence that the terminal begins with, and the findings beside it.
    const answerOf = (r) => say(r.answer || (r.findings || [])[0] || "");
    const detailsOf = (r) => (r.findings || []).filter((s, i) => i > 0 || (r.answer && r.answer !== s)).map(say);
    // null: this command has none.
    const summaryOf = (command, r) => {
        if (!of[command] || !answerOf(r)) return null;
        const { numbers, action } = of[command](r);
        return { verdict: answerOf(r), numbers: numbers.slice(0, 3), action };
    };

    return { widest, rejected, summaryOf, answerOf, detailsOf };
})();
