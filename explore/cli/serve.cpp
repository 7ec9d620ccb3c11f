// pavescape serve: the study's model for other programs, by the UM-Bridge protocol.
#include "cli/commands.h"
#include "report/model_server.h"
#include "run/interrupt.h"

#include <fmt/format.h>

namespace explore::cli {

void add_serve(CLI::App& app, Action& action) {
    auto* command = app.add_subcommand("serve", "the study's model for other programs, by the UM-Bridge protocol");
    auto options = std::make_shared<CommonOptions>();
    auto port = std::make_shared<int>(4242);
    command->add_option("STUDY", options->study, "study file (TOML)")->required();
    command->add_option("--port", *port, "of 127.0.0.1; 0: any that is free")
        ->check(CLI::Range(0, 65535))
        ->capture_default_str();
    command->add_option("--threads", options->threads, "requests computed at once (default: one a core)")
        ->check(within(analysis::allowed::threads));
    command->footer("Ctrl-C ends it. Example: pavescape serve grids/captif-p1-fwd.toml --port 4242");
    command->callback([=, &action] {
        action = [=] {
            run::catch_interrupts();
            report::serve_model(study::load_study(options->study), *port, options->threads,
                                [](const std::string& address) {
                                    fmt::print("model \"forward\" at {}\nCtrl-C ends it.\n", address);
                                    std::fflush(stdout);
                                });
            return static_cast<int>(done);
        };
    });
}

} // namespace explore::cli
