// A long run in short: many cheap evaluations through engine and store, and what grows on the way.
// usage: soak [EVALUATIONS]        (200000); exit status 1: memory or the store grows as it should not
#include "run/engine.h"

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <unistd.h>

namespace {

using namespace explore;

constexpr std::size_t parameters = 4;
constexpr std::size_t responses = 12;

// Twelve smooth responses with their derivatives, at once.
class Cheap final : public problem::ForwardFunction {
public:
    std::unique_ptr<Workspace> make_workspace() const override { return std::make_unique<Workspace>(); }
    pave::Outcome<problem::Prediction> evaluate(std::span<const double> physical, bool with_jacobian,
                                                Workspace&) const override {
        problem::Prediction p;
        p.jacobian.setZero(with_jacobian ? responses : 0, with_jacobian ? parameters : 0);
        for (std::size_t i = 0; i < responses; ++i) {
            double phase = 0.1 * static_cast<double>(i);
            for (std::size_t k = 0; k < parameters; ++k) {
                phase += static_cast<double>(k + 1) * physical[k];
            }
            p.responses.push_back(2.0 + std::sin(phase));
            for (std::size_t k = 0; with_jacobian && k < parameters; ++k) {
                p.jacobian(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(k)) =
                    static_cast<double>(k + 1) * std::cos(phase);
            }
        }
        return p;
    }
};

double resident_mb() {
    std::ifstream stream("/proc/self/statm");
    double size = 0.0;
    double resident = 0.0;
    stream >> size >> resident;
    return resident * static_cast<double>(sysconf(_SC_PAGESIZE)) / 1e6;
}

double store_mb(const std::string& folder) {
    double bytes = 0.0;
    for (const auto& entry : std::filesystem::directory_iterator(folder)) {
        bytes += static_cast<double>(entry.file_size());
    }
    return bytes / 1e6;
}

} // namespace

int main(int argc, char** argv) {
    const std::size_t total = argc > 1 ? std::strtoul(argv[1], nullptr, 10) : 200000;
    constexpr std::size_t of_a_chain = 100;
    constexpr std::size_t parts = 10;
    const std::size_t chains = total / of_a_chain / parts; // of a part
    std::string folder = (std::filesystem::temp_directory_path() / "pavescape-soak-XXXXXX").string();
    if (chains == 0 || mkdtemp(folder.data()) == nullptr) {
        fmt::print(stderr, "soak: at least 1000 evaluations, and a folder TMPDIR that can be written\n");
        return 2;
    }
    problem::ParameterSpace space;
    run::RunHeader header;
    header.key = {"soak", "none", std::to_string(total)};
    for (std::size_t k = 0; k < parameters; ++k) {
        space.axes.push_back({fmt::format("p{}", k), 0.0, 1.0, problem::Scale::linear, 0, 0.5});
        header.parameters.push_back(space.axes.back().name);
    }
    std::vector<problem::Misfit::Term> terms;
    for (std::size_t i = 0; i < responses; ++i) {
        terms.push_back({i, 2.0, 0.1});
        header.responses.push_back(fmt::format("r{}", i));
        header.response_to_si.push_back(1.0);
    }
    const problem::Problem problem{space, std::make_shared<Cheap>(), {problem::MisfitKind::weighted, terms}};

    std::vector<double> memory, size, rate;
    {
        run::Store store(folder, run::Session{});
        const int id = store.begin(header);
        run::Engine engine(problem, &store, id, {.threads = 2, .show_progress = false});
        fmt::print("evaluations   memory [MB]   store [MB]   evaluations per CPU second\n");
        for (std::size_t part = 0; part < parts; ++part) {
            const std::clock_t begin = std::clock();
            engine.chains("soak", static_cast<int>(part * chains), chains, [](std::size_t c, run::Chain& chain) {
                std::vector<double> unit(parameters, 0.5);
                for (std::size_t n = 0; n < of_a_chain; ++n) {
                    const problem::Evaluation e = chain.at(unit);
                    for (std::size_t k = 0; k < parameters; ++k) { // somewhere else, that depends on the answer
                        const double step = e.responses[k] * static_cast<double>(n + c + 1) * 0.618;
                        unit[k] = step - std::floor(step);
                    }
                }
            });
            memory.push_back(resident_mb());
            size.push_back(store_mb(folder));
            rate.push_back(static_cast<double>(chains * of_a_chain) * CLOCKS_PER_SEC /
                           static_cast<double>(std::clock() - begin));
            fmt::print("{:>11} {:>13.2f} {:>12.2f} {:>28.0f}\n", (part + 1) * chains * of_a_chain, memory.back(),
                       size.back(), rate.back());
        }
    }
    std::filesystem::remove_all(folder);
    // After the first fifth, in which buffers reach their size.
    const auto [least, most] = std::minmax_element(memory.begin() + 2, memory.end());
    const double growth = *most / *least - 1.0;
    // The store against the straight line from the third part to the last.
    double bend = 0.0;
    for (std::size_t i = 2; i < parts; ++i) {
        const double straight =
            size[2] + (size.back() - size[2]) * static_cast<double>(i - 2) / static_cast<double>(parts - 3);
        bend = std::max(bend, std::abs(size[i] / straight - 1.0));
    }
    const auto [slowest, fastest] = std::minmax_element(rate.begin(), rate.end());
    fmt::print(
        "memory grows by {:.2f} % (allowed 2), the store bends by {:.2f} % (allowed 5), the rate varies by {:.0f} %\n",
        100 * growth, 100 * bend, 100 * (*fastest / *slowest - 1.0));
    return growth <= 0.02 && bend <= 0.05 ? 0 : 1;
}
