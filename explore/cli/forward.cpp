// pavescape forward: responses at the study's own parameter values.
#include "report/forward.h"
#include "cli/commands.h"
#include "report/vtu.h"
#include "run/files.h"

#include <algorithm>
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
        run::write_file(folder.empty() ? "." : folder, path.filename().string(), report::vtu_text(fields.value()));
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
    report::Json json = report::forward_json(study, model, outcome);
    if (!outcome) {
        return hand_over_failure(options, json,
                                 std::string(to_string(outcome.status())) + ": " + outcome.failure().reason);
    }
    const auto fields = vtu.empty() ? std::vector<std::string>{} : write_fields(study, model, vtu);
    if (options.json) {
        if (!fields.empty()) {
            json["vtu"] = fields;
        }
        fmt::print("{}\n", report::json_text(json));
        return done;
    }
    fmt::print("{}", report::forward_text(study, *outcome));
    for (const std::string& file : fields) {
        fmt::print("  fields for ParaView: {}\n", file);
    }
    if (with_jacobian) {
        fmt::print("{}", report::jacobian_text(study, *outcome));
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
