// pavescape forward: responses at the study's own parameter values.
#include "base/units.h"
#include "cli/common.h"
#include "report/table.h"
#include "report/vtu.h"
#include "run/message.h"

#include <filesystem>
#include <fmt/format.h>
#include <stdexcept>

namespace explore::cli {
namespace {

// FILE for a study of one load, FILE with "-LOAD" before its ending for more. The files that were written.
std::vector<std::string> write_fields(const study::Study& study, const pave::pavement::ForwardModel& model,
                                      const std::string& file) {
    std::vector<std::string> written;
    for (std::size_t l = 0; l < study.model.loads.size(); ++l) {
        const auto fields = model.fields(study.model, static_cast<int>(l));
        if (!fields) {
            throw std::runtime_error(fields.failure().reason);
        }
        std::filesystem::path path(file);
        if (study.model.loads.size() > 1) {
            std::string load = study.model.loads[l].name;
            std::replace(load.begin(), load.end(), '/', '_'); // a name is no folder
            path.replace_filename(path.stem().string() + "-" + load + path.extension().string());
        }
        const std::string folder = path.parent_path().string();
        write_file(folder.empty() ? "." : folder, path.filename().string(), report::vtu_text(fields.value()));
        written.push_back(path.string());
    }
    return written;
}

int forward(const CommonOptions& options, bool with_jacobian, const std::string& vtu) {
    const study::Study study = study::load_study(options.study);
    const pave::pavement::ForwardModel model(study.model);
    const auto workspace = model.make_workspace();
    if (with_jacobian && study.parameters.empty()) {
        throw pave::Error({.file = study.file, .key = "parameters"}, "--jacobian needs parameters to differentiate by",
                          {}, "at least one [[parameters]]");
    }
    const auto outcome =
        model.run(study.model, with_jacobian ? study.parameters : std::vector<pave::pavement::Parameter>{}, *workspace);

    report::Json json = {{"status", std::string(to_string(outcome.status()))}};
    if (!outcome) {
        json["reason"] = outcome.failure().reason;
        if (options.json) {
            fmt::print("{}\n", report::json_text(json));
        }
        run::message("pavescape: {}: {}\n", to_string(outcome.status()), outcome.failure().reason);
        return computation_failed;
    }
    const auto& s = outcome->statistics;
    const auto fields = vtu.empty() ? std::vector<std::string>{} : write_fields(study, model, vtu);
    if (options.json) {
        json["responses"] = report::responses_json(study, outcome->values);
        json["newton_steps"] = s.newton_steps;
        json["load_steps"] = s.load_steps;
        json["factorizations"] = s.factorizations;
        json["iterations"] = s.iterations;
        json["unknowns"] = model.unknowns();
        json["residual_relative"] = s.residual_relative;
        json["warnings"] = outcome->warnings;
        if (!fields.empty()) {
            json["vtu"] = fields;
        }
        if (with_jacobian) {
            report::Json names = report::Json::array();
            report::Json rows = report::Json::array();
            for (const auto& axis : study.space.axes) {
                names.push_back(axis.name);
            }
            for (std::size_t i = 0; i < outcome->values.size(); ++i) {
                report::Json row = report::Json::array();
                for (Eigen::Index k = 0; k < outcome->jacobian.cols(); ++k) {
                    row.push_back(outcome->jacobian(static_cast<Eigen::Index>(i), k) / study.response_to_si(i));
                }
                rows.push_back(std::move(row));
            }
            json["jacobian"] = {{"parameters", std::move(names)}, {"rows", std::move(rows)}};
        }
        fmt::print("{}\n", report::json_text(json));
        return done;
    }
    fmt::print("{}", study_summary(study));
    fmt::print("  converged: {}, {}{}, unbalanced force {:.0e} of the load\n\n",
               study.model.settings.integration == pave::pavement::Integration::secant
                   ? report::counted(static_cast<std::size_t>(s.newton_steps), "Newton step", "Newton steps")
                   : report::counted(static_cast<std::size_t>(s.load_steps), "load step", "load steps"),
               report::counted(static_cast<std::size_t>(s.factorizations), "factorisation", "factorisations"),
               s.iterations > 0 ? fmt::format(", {} conjugate gradient steps", s.iterations) : "", s.residual_relative);
    fmt::print("{}", response_table(study, outcome->values));
    for (const std::string& warning : outcome->warnings) {
        fmt::print("  warning: {}\n", warning);
    }
    for (const std::string& file : fields) {
        fmt::print("  fields for ParaView: {}\n", file);
    }
    if (with_jacobian) {
        std::vector<std::string> header{"d(response)/d(parameter)"};
        for (const auto& axis : study.space.axes) {
            header.push_back(axis.name);
        }
        report::Table table(header);
        const auto names = run_header(study, "", "").responses;
        for (std::size_t i = 0; i < outcome->values.size(); ++i) {
            std::vector<std::string> row{names[i]};
            for (Eigen::Index k = 0; k < outcome->jacobian.cols(); ++k) {
                row.push_back(fmt::format("{:.5g}", outcome->jacobian(static_cast<Eigen::Index>(i), k) /
                                                        study.response_to_si(i)));
            }
            table.add(std::move(row));
        }
        fmt::print("\n{}", table.text());
    }
    return done;
}

} // namespace

void add_forward(CLI::App& app, Action& action) {
    auto* command = app.add_subcommand("forward", "responses at the study's own parameter values");
    auto options = std::make_shared<CommonOptions>();
    auto jacobian = std::make_shared<bool>(false);
    add_common(*command, *options);
    command->add_flag("--jacobian", *jacobian, "also the derivative of every response by every parameter");
    auto vtu = std::make_shared<std::string>();
    command
        ->add_option("--vtu", *vtu,
                     "also the fields of displacement, strain, stress and moduli, for ParaView; one file a load")
        ->type_name("FILE");
    command->footer("Example: pavescape forward grids/captif-p1-fwd.toml --jacobian\n"
                    "         pavescape forward grids/dual-nonlinear.toml --vtu dual.vtu");
    command->callback([=, &action] { action = [=] { return forward(*options, *jacobian, *vtu); }; });
}

} // namespace explore::cli
