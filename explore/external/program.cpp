#include "external/program.h"

#include "base/error.h"
#include "base/passing_failure.h"
#include "base/text.h"
#include "external/child.h"

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <mutex>
#include <stdlib.h>
#include <system_error>

namespace explore::external {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

// The last lines that a program wrote to standard error or, where it is silent there, to standard output.
std::string last_words(const fs::path& folder) {
    for (const char* name : {"stderr.txt", "stdout.txt"}) {
        std::ifstream stream(folder / name, std::ios::binary);
        std::vector<std::string> lines;
        for (std::string line; std::getline(stream, line);) {
            if (line.find_first_not_of(" \t\r") != std::string::npos) {
                lines.push_back(pave::printable(pave::to_utf8(line), 200));
            }
            constexpr std::size_t most = 3;
            if (lines.size() > most) {
                lines.erase(lines.begin());
            }
        }
        if (!lines.empty()) {
            return ": " + pave::join(lines, " | ");
        }
    }
    return "";
}

// Whether a run found no room: nothing it wrote can be relied upon, its answer neither.
bool has_no_room(const fs::path& folder) {
    constexpr std::uintmax_t little = 1 << 16; // bytes
    std::error_code error;
    const fs::space_info space = fs::space(folder, error);
    return !error && space.available < little;
}
bool says_no_room(const std::string& words) {
    return words.find(std::strerror(ENOSPC)) != std::string::npos ||
           words.find(std::strerror(EDQUOT)) != std::string::npos;
}

class Program final : public Simulator {
public:
    Program(ProgramSettings settings, std::vector<std::string> names, std::vector<Wanted> wanted)
        : settings_(std::move(settings)),
          names_(std::move(names)),
          wanted_(std::move(wanted)) {}

    pave::Outcome<std::vector<double>> run(std::span<const double> values) const override {
        std::string folder = (fs::temp_directory_path() / "pavescape-run-XXXXXX").string();
        if (mkdtemp(folder.data()) == nullptr) {
            return passing(fmt::format("no folder can be made in {}: {}", fs::temp_directory_path().string(),
                                       std::strerror(errno)));
        }
        auto outcome = [&]() -> pave::Outcome<std::vector<double>> {
            try {
                return run_in(folder, values);
            } catch (const fs::filesystem_error& error) {
                return passing(error.what());
            }
        }();
        leave(folder, static_cast<bool>(outcome));
        return outcome;
    }

    bool has_jacobian() const override { return false; }
    pave::Outcome<Eigen::MatrixXd> jacobian(std::span<const double>) const override {
        return pave::Failure{pave::Status::failed, "a program offers no derivatives"};
    }

    std::string description() const override {
        Json inputs = Json::array();
        for (const auto& input : settings_.inputs) {
            inputs.push_back({input.from.text(), input.from.file(), input.file});
        }
        Json files = Json::array();
        for (const auto& link : settings_.files) {
            files.push_back({link.name, link.target});
        }
        const Json all = {{"type", "program"},
                          {"command", settings_.command},
                          {"inputs", std::move(inputs)},
                          {"files", std::move(files)},
                          {"outputs", outputs_json(settings_.outputs)},
                          {"time_limit", settings_.time_limit},
                          {"keep", static_cast<int>(settings_.keep)},
                          {"names", names_},
                          {"wanted", wanted_json(wanted_)}};
        return all.dump();
    }

    void keep_in(const std::string& folder) const override {
        const std::scoped_lock lock(mutex_);
        folder_ = folder;
    }

    std::string kept_words() const override {
        const std::scoped_lock lock(mutex_);
        return kept_ == 0 ? ""
                          : fmt::format("{} of the program {} kept: {}", pave::counted(kept_, "run", "runs"),
                                        kept_ == 1 ? "is" : "are", last_kept_);
    }

private:
    // Another attempt may have an answer: not kept in a store.
    static pave::Failure passing(const std::string& reason) {
        return {pave::Status::failed, fmt::format("{} ({})", reason, pave::passing_words)};
    }

    pave::Outcome<std::vector<double>> run_in(const fs::path& folder, std::span<const double> values) const {
        for (const auto& link : settings_.files) {
            fs::create_directories((folder / link.name).parent_path());
            fs::create_symlink(link.target, folder / link.name);
        }
        for (const auto& input : settings_.inputs) {
            auto text = input.from.filled(values);
            if (!text) {
                return text.failure();
            }
            fs::create_directories((folder / input.file).parent_path());
            std::ofstream stream(folder / input.file, std::ios::binary);
            stream << *text;
            stream.close();
            if (!stream) {
                return passing(
                    fmt::format("{} cannot be written: {}", (folder / input.file).string(), std::strerror(errno)));
            }
        }
        const ChildEnd end = run_child(settings_.command, folder.string(), settings_.time_limit);
        const std::string& name = settings_.command[0];
        const bool is_full = has_no_room(folder);
        const std::string full = fmt::format("no room is left in {}", fs::temp_directory_path().string());
        const auto failed = [&](const std::string& reason) {
            return is_full                ? passing(fmt::format("{}; {}", reason, full))
                   : says_no_room(reason) ? passing(reason)
                                          : pave::Failure{pave::Status::failed, reason};
        };
        switch (end.kind) {
        case ChildEnd::Kind::not_started: return passing(fmt::format("{} cannot be started: {}", name, end.reason));
        case ChildEnd::Kind::over_time:
            return passing(fmt::format("{} ran longer than time_limit_s = {:g} and was ended{}", name,
                                       settings_.time_limit, last_words(folder)));
        case ChildEnd::Kind::killed:
            return failed(fmt::format("{} was ended by signal {} ({}){}", name, end.code, strsignal(end.code),
                                      last_words(folder)));
        case ChildEnd::Kind::exited: break;
        }
        if (end.code != 0) {
            return failed(fmt::format("{} ended with status {}{}", name, end.code, last_words(folder)));
        }
        auto read = read_outputs(settings_.outputs, wanted_, folder.string());
        if (!read) {
            return failed(fmt::format("{} ended well, but {}{}", name, read.failure().reason, last_words(folder)));
        }
        if (is_full) {
            return passing(fmt::format("{} ended well, but {}: what it wrote may be cut off", name, full));
        }
        return read;
    }

    // Removes the folder of a run, or puts it where it is kept.
    void leave(const std::string& folder, bool answered) const {
        const std::scoped_lock lock(mutex_);
        constexpr std::size_t most_failed = 20;
        const bool stays =
            settings_.keep == Keep::all || (settings_.keep == Keep::failed && !answered && kept_ < most_failed);
        std::error_code error; // of what cannot be kept the run itself is no worse
        if (stays) {
            ++kept_;
            last_kept_ = folder;
            if (!folder_.empty()) {
                fs::create_directories(folder_, error);
                fs::path to;
                do {
                    to = fs::path(folder_) / fmt::format("{}-{}", answered ? "run" : "failed", ++number_);
                } while (fs::exists(to, error));
                fs::rename(folder, to, error);
                if (error) { // on another file system
                    fs::copy(folder, to, fs::copy_options::recursive | fs::copy_options::copy_symlinks, error);
                    fs::remove_all(folder, error);
                }
                last_kept_ = folder_;
            }
            return;
        }
        fs::remove_all(folder, error);
    }

    ProgramSettings settings_;
    std::vector<std::string> names_;
    std::vector<Wanted> wanted_;
    mutable std::mutex mutex_;
    mutable std::string folder_, last_kept_;
    mutable std::size_t kept_ = 0;
    mutable std::size_t number_ = 0;
};

} // namespace

std::shared_ptr<const Simulator> make_program(ProgramSettings settings, std::vector<std::string> names,
                                              std::vector<Wanted> wanted) {
    return std::make_shared<Program>(std::move(settings), std::move(names), std::move(wanted));
}

std::shared_ptr<const Simulator> program_of(const Json& all) {
    const auto names = all.at("names").get<std::vector<std::string>>();
    ProgramSettings settings{.command = all.at("command").get<std::vector<std::string>>(),
                             .inputs = {},
                             .files = {},
                             .outputs = outputs_of(all.at("outputs")),
                             .time_limit = all.at("time_limit"),
                             .keep = static_cast<Keep>(all.at("keep").get<int>())};
    for (const Json& input : all.at("inputs")) {
        settings.inputs.push_back({Template(input.at(0), input.at(1), names), input.at(2)});
    }
    for (const Json& link : all.at("files")) {
        settings.files.push_back({link.at(0), link.at(1)});
    }
    return make_program(std::move(settings), names, wanted_of(all.at("wanted")));
}

} // namespace explore::external
