#include "cli/common.h"

#include "base/error.h"
#include "base/text.h"
#include "base/units.h"
#include "fe/sparse_solver.h"
#include "pavement/effects/effect.h"
#include "report/table.h"
#include "run/message.h"
#include "run/parallel.h"

#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <nlopt.hpp>
#include <oneapi/tbb/version.h>
#include <unistd.h>

namespace explore::cli {

using report::figure;

CLI::Validator within(double low, double high) {
    return {[=](std::string& text) {
                double value = NAN;
                return CLI::detail::lexical_cast(text, value) && value >= low && value <= high
                           ? std::string()
                           : fmt::format("{} is not a number from {} to {}", text, low, high);
            },
            fmt::format("{} - {}", low, high)};
}

namespace {

// CLI11 reads -1 as the largest number there is.
CLI::Validator whole_number() {
    return {[](std::string& text) {
                std::uint64_t value = 0;
                const char* end = text.data() + text.size();
                const auto read = std::from_chars(text.data(), end, value);
                return read.ec == std::errc() && read.ptr == end
                           ? std::string()
                           : fmt::format("{} is not a whole number from 0 to {}", text,
                                         std::numeric_limits<std::uint64_t>::max());
            },
            "UINT"};
}

} // namespace

void add_run_options(CLI::App& app, CommonOptions& options, const std::string& default_folder) {
    app.add_option("--out", options.out, "folder for the results (default: " + default_folder + ")");
    app.add_option("--threads", options.threads, "number of threads (default: one a core)")->check(CLI::Range(1, 4096));
    app.add_option("--seed", options.seed, "fixes what is random")->check(whole_number())->capture_default_str();
    app.add_flag("--json", options.json, "print one JSON object and nothing else");
}

void add_common(CLI::App& app, CommonOptions& options) {
    app.add_option("STUDY", options.study, "study file (TOML)")->required();
    add_run_options(app, options, "output/<study name>");
}

namespace {
std::vector<std::string> command_line; // one a process
}

void remember_command_line(int argc, const char* const* argv) {
    command_line.assign(argv + 1, argv + argc);
}

namespace {

std::string library_words() {
    return fmt::format("Eigen {}.{}.{}, {}, TBB {}.{}, NLopt {}.{}.{}, {}", EIGEN_WORLD_VERSION, EIGEN_MAJOR_VERSION,
                       EIGEN_MINOR_VERSION, pave::fe::sparse_solver_version(), TBB_VERSION_MAJOR, TBB_VERSION_MINOR,
                       nlopt::version_major(), nlopt::version_minor(), nlopt::version_bugfix(), PAVESCAPE_COMPILER);
}

} // namespace

std::string build_words() {
    return fmt::format("{}, {}", PAVESCAPE_VERSION, library_words());
}

run::Session session(const CommonOptions& options) {
    return {.version = PAVESCAPE_VERSION,
            .libraries = library_words(),
            .arguments = command_line,
            .directory = std::filesystem::current_path().string(),
            .threads = run::concurrency(options.threads)};
}

run::RunHeader run_header(const study::Study& study, std::string command, std::string settings) {
    run::RunHeader header;
    header.key = {std::move(command), study.hash, std::move(settings)};
    header.version = PAVESCAPE_VERSION;
    for (const auto& axis : study.space.axes) {
        header.parameters.push_back(axis.name);
    }
    for (std::size_t i = 0; i < study.responses(); ++i) {
        const auto& s = study.model.sensors[i];
        const std::string unit(study.response_unit(i));
        header.responses.push_back(
            i < study.measurements.size()
                ? fmt::format("{}.{}@{:g},{:g},{:g} [{}]", study.model.loads[s.load].name, info(s.quantity).name,
                              s.x / pave::unit::mm, s.y / pave::unit::mm, s.depth / pave::unit::mm, unit)
                : fmt::format("{} [{}]", study.outputs[i - study.measurements.size()].name, unit));
        header.response_to_si.push_back(study.response_to_si(i));
    }
    return header;
}

void write_file(const std::string& folder, const std::string& name, const std::string& text) {
    std::error_code error;
    std::filesystem::create_directories(folder, error);
    const auto path = std::filesystem::path(folder) / name;
    // Of its own: another process may be writing the same file.
    const auto part = std::filesystem::path(folder) / fmt::format("{}.{}.part", name, getpid());
    const auto remove_part = [&] {
        std::error_code ignored;
        std::filesystem::remove(part, ignored);
    };
    {
        std::ofstream stream(part, std::ios::binary);
        if (!stream) {
            throw pave::Error({.file = path.string()}, "cannot be written", std::strerror(errno),
                              "a folder that can be written (--out)");
        }
        stream << text;
        stream.close();
        if (!stream) {
            const std::string reason = std::strerror(errno);
            remove_part();
            throw std::runtime_error(fmt::format("{}: no room to write it: {}", path.string(), reason));
        }
    }
    std::filesystem::rename(part, path, error);
    if (error) {
        remove_part();
        throw pave::Error({.file = path.string()}, "cannot be written", error.message(), "another folder (--out)");
    }
}

std::string study_summary(const study::Study& study) {
    std::string text = pave::printable(study.title) + "\n  ";
    for (const auto& layer : study.model.layers) {
        text += fmt::format("{} {:g} mm ({}) / ", layer.name, layer.thickness / pave::unit::mm, layer.law->name());
    }
    text += "rigid floor\n";
    for (const auto& applied : study.model.effects) {
        text += fmt::format("  with {} = {:g} [{}]\n", applied.effect->name, applied.size, applied.effect->unit);
    }
    if (study.noise_assumed > 0) {
        text += fmt::format("  {} of {} state no standard deviation and take the median share of those that do\n",
                            study.noise_assumed, report::counted(study.measurements.size(), "reading", "readings"));
    }
    return text;
}

std::string response_table(const study::Study& study, const std::vector<double>& responses) {
    report::Table table(
        {"load", "quantity", "x mm", "y mm", "depth mm", "gauge mm", "measured", "model", "unit", "difference"});
    for (std::size_t i = 0; i < responses.size(); ++i) {
        const auto& s = study.model.sensors[i];
        const bool measured = i < study.measurements.size();
        const double model = responses[i] / study.response_to_si(i);
        const double data = measured ? study.measurements[i].value : 0.0;
        const auto mm = [](double metres) { return fmt::format("{:g}", metres / pave::unit::mm); };
        table.add({study.model.loads[s.load].name,
                   measured ? std::string(info(s.quantity).name) : study.outputs[i - study.measurements.size()].name,
                   mm(s.x), mm(s.y), mm(s.depth), mm(s.gauge), measured ? fmt::format("{}", data) : "", figure(model),
                   std::string(study.response_unit(i)),
                   measured && data != 0.0 ? fmt::format("{:+.1f} %", 100.0 * (model / data - 1.0)) : ""});
    }
    return fmt::format("  {}\n{}", sign_convention, table.text());
}

int report_interrupt(const std::string& folder) {
    run::message("interrupted: what was computed is kept in {}; the same command continues\n", folder);
    return was_interrupted;
}

} // namespace explore::cli
