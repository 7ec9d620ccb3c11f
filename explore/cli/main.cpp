#include "base/error.h"
#include "cli/common.h"
#include "run/interrupt.h"

#include <fmt/format.h>
#include <malloc.h>

int main(int argc, char** argv) {
    namespace cli = explore::cli;
    // Sparse factorisations allocate and free the same few megabytes thousands of times: keep them.
    mallopt(M_MMAP_THRESHOLD, 1 << 30);
    mallopt(M_TRIM_THRESHOLD, 1 << 30);
    mallopt(M_TOP_PAD, 16 << 20);
    CLI::App app{"Pavescape calibrates stress-dependent pavement models and says whether the answer can be trusted."};
    app.name("pavescape");
    app.set_version_flag("--version", PAVESCAPE_VERSION);
    app.require_subcommand(1);
    cli::Action action;
    cli::add_forward(app, action);
    cli::add_map(app, action);
    cli::add_fit(app, action);
    cli::add_twin(app, action);
    cli::add_export(app, action);
    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
        const int status = app.exit(error);
        return status == 0 ? cli::done : cli::wrong_input;
    }
    explore::run::catch_interrupts();
    try {
        return action();
    } catch (const pave::Error& error) {
        fmt::print(stderr, "pavescape: {}\n", error.what());
        return cli::wrong_input;
    } catch (const std::exception& error) {
        fmt::print(stderr, "pavescape: the computation failed: {}\n", error.what());
        return cli::computation_failed;
    }
}
