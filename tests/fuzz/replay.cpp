// A fuzz target without a fuzzer: every file of a folder, then random changes of them. Finds what once was found again,
// with any compiler. usage: replay_TARGET FOLDER CHANGES SEED
#include "base/random.h"

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace {

void one(const std::string& text) {
    LLVMFuzzerTestOneInput(reinterpret_cast<const std::uint8_t*>(text.data()), text.size());
}

class Mutator {
public:
    Mutator(const std::vector<std::string>& inputs, std::uint64_t seed) : inputs_(inputs), random_(seed, 0) {}

    std::string next() {
        std::string text = any_input();
        for (std::size_t n = 1 + below(6); n > 0; --n) {
            change(text);
        }
        return text;
    }

private:
    std::size_t below(std::size_t n) {
        return std::min(static_cast<std::size_t>(random_.uniform(count_++) * static_cast<double>(n)), n - 1);
    }
    const std::string& any_input() { return inputs_[below(inputs_.size())]; }

    void change(std::string& text) {
        static const std::string_view words[] = {
            "nan", "-1", "1e308", "-1e-320", "99999999999999999999",   "\"", "\n", ",",
            "[",   "]",  "=",     "",        std::string_view("\0", 1)};
        const std::size_t from = below(text.size() + 1);
        const std::size_t length = below(std::min<std::size_t>(text.size() - from, 24) + 1);
        switch (below(4)) {
        case 0: // a part of another input
        {
            const std::string& other = any_input();
            const std::size_t start = below(other.size() + 1);
            text.replace(from, length, other.substr(start, below(64)));
            break;
        }
        case 1: text.replace(from, length, words[below(std::size(words))]); break;
        case 2: text.insert(from, text.substr(from, length)); break;
        default:
            if (from < text.size()) {
                text[from] = static_cast<char>(below(256));
            }
        }
    }

    const std::vector<std::string>& inputs_;
    pave::RandomStream random_;
    std::uint64_t count_ = 0;
};

} // namespace

int main(int argc, char** argv) {
    if (argc != 4) {
        fmt::print(stderr, "usage: {} FOLDER CHANGES SEED\n", argv[0]);
        return 2;
    }
    std::vector<std::string> inputs;
    for (const auto& entry : std::filesystem::directory_iterator(argv[1])) {
        std::ostringstream text;
        text << std::ifstream(entry.path(), std::ios::binary).rdbuf();
        inputs.push_back(text.str());
    }
    std::sort(inputs.begin(), inputs.end());
    for (const std::string& input : inputs) {
        one(input);
    }
    if (inputs.empty()) {
        fmt::print(stderr, "{} holds no files\n", argv[1]);
        return 2;
    }
    Mutator mutator(inputs, std::strtoull(argv[3], nullptr, 10));
    for (long n = std::strtol(argv[2], nullptr, 10); n > 0; --n) {
        one(mutator.next());
    }
    fmt::print("{} inputs and {} changes of them\n", inputs.size(), argv[2]);
    return 0;
}
