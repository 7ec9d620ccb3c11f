// Names as an engineer says them: parameters, quantities, loads and readings, alone or within a sentence.
"use strict";
const wording = (() => {
    const units = [["_kg_m3", "kg/m³"], ["_MPa", "MPa"], ["_kPa", "kPa"], ["_GPa", "GPa"], ["_kN", "kN"], ["_mm", "mm"], ["_um", "µm"], ["_ms", "ms"], ["_percent", "%"], ["_C", "°C"]];
    const unit = (text) => (text === "um" ? "µm" : text);
    // "strain_zz": "vertical strain".
    const quantity = (name) => {
        if (name === "benkelman") return "Benkelman deflection";
        const [kind, axis] = name.split("_");
        const way = { zz: "vertical", xx: "transverse", yy: "longitudinal" }[axis];
        return way ? `${way} ${kind}` : name.replaceAll("_", " ");
    };
    // "subgrade.modulus_MPa": "subgrade modulus" and "MPa".
    const parameter = (name) => {
        const found = units.find(([ending]) => name.endsWith(ending) && name.length > ending.length);
        const stem = found ? name.slice(0, -found[0].length) : name;
        return { name: stem.replace(/\.(?=\D)/g, " ").replaceAll("_", " "), unit: found ? found[1] : "" };
    };
    const titled = (name) => {
        const { name: stem, unit: of } = parameter(name);
        return of ? `${stem} [${of}]` : stem;
    };

    const loads = new Map();
    const reading = new Map(); // a load's name to its words
    // The loads of the texts of studies: a plate or wheels by their force, a name beside it where two would read alike.
    const readStudies = (studies) => {
        for (const { text } of studies) {
            for (const block of (text || "").split(/^\s*\[\[/m).filter((b) => b.startsWith("loads]]"))) {
                const of = (key) => (block.match(new RegExp(`^\\s*${key}\\s*=\\s*"?([^"#\\n]+)`, "m")) || [])[1];
                const number = (key) => (of(key) === undefined ? NaN : Number(of(key)));
                const [name, type] = [(of("name") || "").trim(), (of("type") || "plate").trim()];
                const force = Number.isFinite(number("force_kN")) ? number("force_kN") : Math.PI * number("pressure_kPa") * number("radius_mm") ** 2 * 1e-6;
                if (name === "" || !Number.isFinite(force) || of("history") !== undefined) continue;
                const size = `${Math.abs(force - Math.round(force)) < 0.06 * Math.round(force) && force > 10 ? Math.round(force) : Number(force.toPrecision(3))} kN`;
                loads.set(name, type === "plate" ? `the ${size} drop` : type === "dual-wheel" ? `the ${size} dual wheel` : `the ${size} ${type.replaceAll("-", " ")}`);
            }
        }
        const count = (words) => [...loads.values()].filter((w) => w === words).length;
        for (const [name, words] of loads) reading.set(name, count(words) > 1 ? `${words} (${name})` : words);
    };
    const load = (name) => reading.get(name) || name;
    const metres = (mm) => (mm >= 100 ? `${Number((mm / 1000).toPrecision(3))} m` : `${Number(mm.toPrecision(3))} mm`);
    // "deflection at 900 mm under the 40 kN drop", "vertical strain 0.31 m below the surface under the 40 kN dual wheel"
    const readingWords = (r) => `${quantity(r.quantity)}${r.depth_mm ? ` ${metres(r.depth_mm)} below the surface` : ""}` +
        `${r.quantity === "deflection" || r.x_mm ? ` at ${Number(r.x_mm.toPrecision(4))} mm` : ""} under ${load(r.load)}`;

    // Within a sentence of the program; names: of parameters.
    let names = [];
    const knowParameters = (list) => { names = [...new Set([...names, ...list])].sort((a, b) => b.length - a.length); };
    // Of files, which the last part of their paths tells apart.
    let short = [];
    const knowPaths = (list) => {
        const last = (path) => path.split("/").pop().replace(/\.toml$/, "");
        short = list.filter((path) => list.filter((other) => last(other) === last(path)).length === 1).map((path) => [path, last(path)]).sort((a, b) => b[0].length - a[0].length);
    };
    const escaped = (text) => text.replace(/[.*+?^${}()|[\]\\]/g, "\\$&");
    const say = (sentence) => {
        let text = String(sentence);
        for (const [path, name] of short) text = text.replaceAll(path, name);
        // The unit goes behind the value, "base modulus = 300 MPa"; without a value there is none.
        for (const name of names.filter((n) => n.includes("."))) {
            const { name: words, unit: of } = parameter(name);
            const number = "-?\\d[\\d.e+-]*";
            text = text.replace(new RegExp(`(?<![\\w.])${escaped(name)}(?: (=|lies between|anywhere from|from|is))?(?: (${number}(?: (?:to|and) ${number})?)(?! ?%|[\\w]))?(?![\\w])`, "g"),
                (_, link, value) => `${words}${link ? ` ${link}` : ""}${value ? ` ${value.replace(/\.$/, "")}${of ? ` ${of}` : ""}${value.endsWith(".") ? "." : ""}` : ""}`);
        }
        text = text.replace(/\b(strain|stress)_(zz|xx|yy)\b/g, (name) => quantity(name)).replace(/(\d(?:[\d.]*\d)?) mm deep\b/g, (_, mm) => `${metres(Number(mm))} below the surface`);
        for (const [name, words] of reading) {
            text = text.replace(new RegExp(`\\bunder ${escaped(name)}(?![\\w-])`, "g"), `under ${words}`)
                .replace(new RegExp(`(?<![\\w.])${escaped(name)}\\.(deflection|strain|stress)\\b`, "g"), (_, of) => `${of} under ${words}`);
        }
        return text.replace(/\bchi2\b/g, "χ²");
    };

    return { unit, quantity, parameter, titled, load, readStudies, readingWords, knowParameters, knowPaths, say };
})();
