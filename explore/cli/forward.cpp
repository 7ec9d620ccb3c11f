// pavescape forward: responses at the study's own parameter values, at others, at a list of them.
#include "report/forward.h"
#include "analysis/common/load_steps.h"
#include "cli/commands.h"
#include "report/vtu.h"
#include "run/files.h"
#include "study/problems.h"
#include "study/values.h"

#include <algorithm>
#include <fmt/format.h>

namespace explore::cli {
namespace {

struct ForwardArguments {
    CommonOptions common;
    bool jacobian = false;
    std::string vtu, points;
    std::vector<std::string> set;
};

int forward_at_points(const ForwardArguments& options, study::Study study) {
    const auto known = study::names_of_numbers(study);
    auto points = analysis::read_points(options.points, {known.begin(), known.end()});
    const auto computed = analysis::compute_points(study, std::move(points), options.points, options.common.threads);
    if (!computed) {
        return was_interrupted;
    }
    fmt::print("{}", options.common.json ? report::json_text(report::points_json(study, *computed)) + "\n"
                                         : report::points_csv(study, *computed));
    const auto& all = computed->responses;
    if (std::none_of(all.begin(), all.end(), [](const auto& outcome) { return static_cast<bool>(outcome); })) {
        complain("no point has an answer; the first: " + all[0].failure().reason);
        return computation_failed;
    }
    return done;
}

int forward(const ForwardArguments& options) {
    std::vector<study::NamedValue> values;
    for (const std::string& text : options.set) {
        values.push_back(study::named_value(text, {.key = "--set"}));
    }
    const auto [study, at] = study::with_values(study::load_study(options.common.study), values, {.key = "--set"});
    if (!options.points.empty()) {
        study::Study around = study;
        around.model = at; // what the points do not name
        return forward_at_points(options, std::move(around));
    }
    if (!options.vtu.empty()) {
        study::refuse_own_model(study, "--vtu");
    }
    const auto model =
        study.has_own_model ? nullptr : std::make_unique<const pave::pavement::ForwardModel>(study.model);
    if (options.jacobian && study.parameters.empty()) {
        throw pave::Error({.file = study.file, .key = "parameters"}, "--jacobian needs parameters to differentiate by",
                          {}, "at least one [[parameters]]");
    }
    const std::vector<pave::pavement::Parameter> none;
    const auto outcome = analysis::with_path_warning(
        study, at,
        model ? model->run(at, options.jacobian ? study.parameters : none, *model->make_workspace())
              : study::own_response(study, at, options.jacobian));
    report::Json json = report::forward_json(study, model.get(), outcome, values);
    if (!outcome) {
        return hand_over_failure(options.common, json,
                                 std::string(to_string(outcome.status())) + ": " + outcome.failure().reason);
    }
    const auto fields =
        options.vtu.empty() ? std::vector<std::string>{} : report::write_fields(study, *model, at, options.vtu);
    if (!fields.empty()) {
        json["vtu"] = fields;
    }
    if (!options.common.out.empty()) {
        run::write_file(options.common.out, "forward.json", report::json_text(json) + "\n");
    }
    if (options.common.json) {
        fmt::print("{}\n", report::json_text(json));
        return done;
    }
    std::string page = report::forward_text(study, *outcome, values, fields);
    if (options.jacobian) {
        page += report::jacobian_text(study, *outcome);
    }
    fmt::print("{}", shown_answer(options.common, report::forward_answer(study, *outcome, values, fields), page));
    return done;
}

} // namespace

void add_forward(CLI::App& app, Action& action) {
    auto* command = app.add_subcommand("forward", "responses at the study's own parameter values, or at others");
    auto options = std::make_shared<ForwardArguments>();
    add_common(*command, options->common);
    add_depth(*command, options->common);
    auto* jacobian =
        command->add_flag("--jacobian", options->jacobian, "also the derivative of every response by every parameter");
    auto* vtu = command
                    ->add_option("--vtu", options->vtu,
                                 "also the fields of displacement, strain, stress and moduli, for ParaView; one file a "
                                 "load")
                    ->type_name("FILE");
    command
        ->add_option("--set", options->set,
                     "NAME=VALUE: a number of the study at another value, as base.k1=900 (repeatable)")
        ->type_name("NAME=VALUE")
        ->expected(1)
        ->take_all();
    command
        ->add_option("--points", options->points,
                     "parameter sets, one a line under a header with their names: prints a line of readings and "
                     "outputs for each")
        ->type_name("FILE.csv")
        ->excludes(jacobian)
        ->excludes(vtu);
    command->footer("Example: pavescape forward grids/captif-p1-fwd.toml --jacobian\n"
                    "         pavescape forward grids/captif-p1-fwd.toml --set base.k1=900 --set base.n=0.5\n"
                    "         pavescape forward grids/dual-nonlinear.toml --vtu dual.vtu");
    command->callback([=, &action] { action = [=] { return forward(*options); }; });
}

} // namespace explore::cli
