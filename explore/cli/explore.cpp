// pavescape explore: the study on a page of this machine, under one's hands.
#include "cli/commands.h"
#include "report/explore_server.h"
#include "run/interrupt.h"

#include <fmt/format.h>

namespace explore::cli {

void add_explore(CLI::App& app, Action& action) {
    auto* command =
        app.add_subcommand("explore", "sliders, readings and landscape on a page that this machine alone sees");
    auto options = std::make_shared<CommonOptions>();
    auto port = std::make_shared<int>(0);
    auto limit = std::make_shared<double>(analysis::ModelOptions().limit_percent);
    command->add_option("STUDY", options->study, "study file (TOML)")->required();
    command->add_option("--port", *port, "of 127.0.0.1; 0: any that is free")
        ->check(CLI::Range(0, 65535))
        ->capture_default_str();
    command->add_option("--out", options->out, "folder that keeps the reduced model (default: output/<study name>)")
        ->type_name("DIR");
    command->add_option("--threads", options->threads, "number of threads (default: one a core)")
        ->check(CLI::Range(1, 4096));
    command
        ->add_option("--model-error", *limit,
                     "estimated error of a reading [%] above which the full model runs in place of the reduced one")
        ->check(within(0.01, 100.0))
        ->capture_default_str();
    command->footer("Ctrl-C ends it. Example: pavescape explore grids/captif-p1-fwd.toml");
    command->callback([=, &action] {
        action = [=] {
            run::catch_interrupts();
            study::Study study = study::load_study(options->study);
            analysis::Session session(options->run(study));
            const auto explorer = analysis::Explorer::make(session, std::move(study), *limit);
            if (!explorer) {
                return static_cast<int>(was_interrupted);
            }
            report::serve_explorer(*explorer, *port, [](const std::string& address) {
                fmt::print("open {}\nCtrl-C ends it.\n", address);
                std::fflush(stdout);
            });
            return static_cast<int>(done);
        };
    });
}

} // namespace explore::cli
