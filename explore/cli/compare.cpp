// pavescape compare: the same data, each law in the same layer, each fitted by the same search.
#include "report/compare.h"
#include "cli/commands.h"

namespace explore::cli {
namespace {

struct CompareArguments {
    CommonOptions common;
    analysis::CompareOptions compare;
    std::vector<std::string> others;
};

int compare(const CompareArguments& options) {
    const study::Study study = study::load_study(options.common.study);
    std::vector<study::Study> studies{study};
    for (const std::string& other : options.others) {
        studies.push_back(study::load_study(other));
    }
    analysis::Session session(options.common.run(study));
    const auto result = studies.size() > 1 ? analysis::compare_studies(session, studies, options.compare)
                                           : analysis::compare(session, study, options.compare);
    if (!result) {
        return report_interrupt(session.folder());
    }
    const int status = hand_over_answer(
        session, options.common, "compare", report::compare_json(*result, session.options()),
        report::compare_answer(*result, session.options()), report::compare_text(*result, session.options()));
    if (result->failed()) {
        complain(result->reason());
    }
    return result->failed() ? computation_failed : status;
}

} // namespace

void add_compare(CLI::App& app, Action& action) {
    auto* command = app.add_subcommand(
        "compare", "the same data, another law in the same layer, or another study: which do they prefer?");
    auto options = std::make_shared<CompareArguments>();
    add_common(*command, options->common);
    add_depth(*command, options->common);
    auto* layer = command->add_option("--layer", options->compare.layer,
                                      "the layer in question (default: the one whose law depends on stress)");
    auto* laws = command->add_option("--laws", options->compare.laws, "laws to compare (default: all)")->delimiter(',');
    command
        ->add_option("OTHER", options->others,
                     "other studies with the same readings: each as it is, in place of laws in one layer")
        ->excludes(layer)
        ->excludes(laws);
    command
        ->add_option("--explore", options->compare.settings.explore,
                     "points of each law's Sobol sample, with derivatives")
        ->check(within(analysis::allowed::compare_explore))
        ->capture_default_str();
    command
        ->add_option("--verify", options->compare.settings.verify,
                     "independent searches of each law that must find no new minimum before the search ends")
        ->check(within(analysis::allowed::compare_verify))
        ->capture_default_str();
    command->add_flag("--evidence", options->compare.evidence, "sample each law's posterior too, for its evidence");
    command->footer("Example: pavescape compare grids/captif-p1-unique-fwd.toml --laws uzan,k-theta,linear");
    command->callback([=, &action] { action = [=] { return compare(*options); }; });
}

} // namespace explore::cli
