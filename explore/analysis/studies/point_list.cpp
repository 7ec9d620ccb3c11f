#include "analysis/studies/point_list.h"

#include "base/error.h"
#include "data/csv.h"
#include "problem/workspaces.h"
#include "run/parallel.h"
#include "study/problems.h"
#include "study/values.h"

#include <algorithm>
#include <limits>

namespace explore::analysis {

PointList read_points(const std::string& file, const std::vector<std::string>& known) {
    const data::CsvTable table = data::parse_table(data::read_file(file, "list of points"), file);
    if (table.rows.size() < 2) {
        throw pave::Error({.file = file}, "the file holds no points",
                          table.rows.empty() ? "nothing but comments or blank lines" : "a header alone",
                          "a header with names of parameters, and a set of values a line");
    }
    const data::CsvRow& header = table.rows[0];
    const std::string first(data::trimmed(header.cells[0]));
    const bool is_own = first == "phase" || first == "population"; // of export, of sample
    PointList list;
    std::vector<std::size_t> columns;
    std::optional<std::size_t> misfit;
    for (std::size_t i = 0; i < header.cells.size(); ++i) {
        const std::string name(data::trimmed(header.cells[i]));
        const pave::Place place{.file = file, .line = header.line, .key = name};
        if (std::find(known.begin(), known.end(), name) != known.end()) {
            if (std::find(list.names.begin(), list.names.end(), name) != list.names.end()) {
                throw pave::Error(place, "this column appears twice", {}, "each once");
            }
            list.names.push_back(name);
            columns.push_back(i);
        } else if (name == "misfit") {
            misfit = i;
        } else if (!is_own) {
            const std::string near = pave::nearest_name(name, known);
            throw pave::Error(place, near.empty() ? "unknown column" : "unknown column, did you mean \"" + near + "\"?",
                              "\"" + name + "\"", pave::join(known));
        }
    }
    if (list.names.empty()) {
        throw pave::Error({.file = file, .line = header.line}, "no column is a parameter", first, pave::join(known));
    }
    for (std::size_t r = 1; r < table.rows.size(); ++r) {
        const data::CsvRow& row = table.rows[r];
        if (row.cells.size() != header.cells.size()) {
            throw pave::Error({.file = file, .line = row.line}, "wrong number of cells",
                              std::to_string(row.cells.size()), std::to_string(header.cells.size()));
        }
        std::vector<double> values;
        for (std::size_t c = 0; c < columns.size(); ++c) {
            values.push_back(table.number(data::trimmed(row.cells[columns[c]]),
                                          {.file = file, .line = row.line, .key = list.names[c]}));
        }
        if (misfit) { // of a point without an answer there is none
            list.misfit.push_back(data::number_or_nothing(data::trimmed(row.cells[*misfit]))
                                      .value_or(std::numeric_limits<double>::quiet_NaN()));
        }
        list.values.push_back(std::move(values));
        list.lines.push_back(row.line);
    }
    return list;
}

std::optional<ComputedPoints> compute_points(study::Study study, PointList points, const std::string& file,
                                             int threads) {
    const auto parameters = study::changeable(study, points.names, {.file = file});
    const auto function = study::function_of(study, parameters, {});
    const int count = run::usable_threads(threads);
    const tbb::global_control most(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(count));
    tbb::task_arena arena(count);
    problem::Workspaces workspaces(*function);
    const std::size_t n = points.values.size();
    ComputedPoints computed{.points = std::move(points), .responses = {}, .warnings = {}};
    computed.responses.assign(n, pave::Failure{pave::Status::failed, "not computed"});
    computed.warnings.resize(n);
    run::for_each_index(arena, n, [&](std::size_t i) {
        auto outcome = workspaces.lend(
            [&](auto& workspace) { return function->evaluate(computed.points.values[i], false, workspace); });
        if (!outcome) {
            computed.responses[i] = outcome.failure();
            return;
        }
        problem::Prediction prediction = std::move(outcome).value();
        computed.responses[i] = std::move(prediction.responses);
        computed.warnings[i] = std::move(prediction.warnings);
    });
    if (run::interrupted()) {
        return std::nullopt;
    }
    return computed;
}

} // namespace explore::analysis
