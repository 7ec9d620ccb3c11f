// pavescape slab: concrete slabs from their bowls.
#include "report/slab.h"
#include "cli/commands.h"

#include <fmt/format.h>

namespace explore::cli {
namespace {

struct SlabArguments {
    std::vector<std::string> files;
    std::string columns;
    analysis::SlabOptions options;
    CommonOptions common; // how much is shown
};

int slab(const SlabArguments& arguments) {
    const auto result = analysis::slabs(data::read_fwd_files(arguments.files, arguments.columns), arguments.options);
    fmt::print("{}", arguments.common.json
                         ? report::json_text(report::slab_json(result)) + "\n"
                         : shown_answer(arguments.common, report::slab_answer(result), report::slab_text(result)));
    const bool any = std::any_of(result.stations.begin(), result.stations.end(),
                                 [](const auto& s) { return s.fit || s.transfer_percent; });
    return any ? done : computation_failed;
}

} // namespace

void add_slab(CLI::App& app, Action& action) {
    using pave::layered::Foundation;
    auto* command = app.add_subcommand("slab", "concrete slabs: foundation, modulus, load transfer, voids");
    auto arguments = std::make_shared<SlabArguments>();
    analysis::SlabOptions& options = arguments->options;
    command->add_option("FILE", arguments->files, "measured FWD files")->required();
    command->add_option("--thickness", options.thickness_mm, "of the slab, mm")->required()->check(within(50, 1000));
    command->add_option("--length", options.length_mm, "of the slabs between joints, mm (with --width; else infinite)")
        ->check(within(1000, 20000));
    command->add_option("--width", options.width_mm, "of the slabs, mm")->check(within(1000, 20000));
    command->add_option("--foundation", options.foundation, "what it lies on: a dense liquid (k) or an elastic solid")
        ->transform(CLI::CheckedTransformer(std::map<std::string, Foundation>{{"liquid", Foundation::dense_liquid},
                                                                              {"solid", Foundation::elastic_solid}}))
        ->default_str("liquid");
    command->add_option("--poisson", options.poisson, "Poisson's ratio of the concrete (0.15)")->check(within(0, 0.49));
    command
        ->add_option("--joints", options.joints,
                     "stations beside a joint, the sensor at 300 mm on the other slab: J1,J2")
        ->delimiter(',')
        ->allow_extra_args(false);
    add_columns(*command, arguments->columns);
    command->add_flag("--json", arguments->common.json, "print one JSON object and nothing else");
    add_depth(*command, arguments->common);
    command->footer("Example: pavescape slab grids/slab-example.csv --thickness 250 --joints J1,J2");
    command->callback([=, &action] { action = [=] { return slab(*arguments); }; });
}

} // namespace explore::cli
