#include "cli/help.h"

#include "base/text.h"
#include "report/answer.h"

#include <algorithm>
#include <fmt/format.h>
#include <regex>

namespace explore::cli {
namespace {

// "1 to 4096" of "INT:INT in [1 - 4096]" and of "FLOAT:1 - 4096"; empty: none is stated.
std::string range_words(const CLI::Option& option) {
    static const std::regex form(R"((?:INT in \[|FLOAT:)(-?[\d.e+]+) - (-?[\d.e+]+)\]?)");
    const std::string type = option.get_type_name();
    std::smatch found;
    return std::regex_search(type, found, form) ? fmt::format("{} to {}", found[1].str(), found[2].str()) : "";
}

} // namespace

bool takes_value(const CLI::Option& option) {
    return option.get_items_expected_max() > 0;
}

std::vector<std::string> words_of(const CLI::Option& option) {
    // "TEXT:{one,other}", and of a map to numbers "ENUM:value in {one->0,other->1} OR {0,1}"; the last check decides.
    std::string type = option.get_type_name();
    type = type.substr(0, type.find(" OR "));
    const std::size_t begin = type.rfind('{');
    const std::size_t end = type.rfind('}');
    std::vector<std::string> words;
    if (begin == std::string::npos || end == std::string::npos) {
        return words;
    }
    for (std::string& word : CLI::detail::split(type.substr(begin + 1, end - begin - 1), ',')) {
        words.push_back(word.substr(0, word.find("->")));
    }
    return words;
}

std::string value_word(const CLI::Option& option) {
    const std::vector<std::string> words = words_of(option);
    if (!words.empty()) {
        return "{" + pave::join(words, ",") + "}";
    }
    const std::string type = option.get_type_name();
    const std::string kind = type.substr(0, type.find(':'));
    if (kind == "INT" || kind == "UINT") {
        return "N";
    }
    return kind == "FLOAT" ? "NUMBER" : type.ends_with(":LOAD") ? "LOAD" : kind;
}

std::string description_of(const CLI::Option& option) {
    std::string text = option.get_description();
    if (!takes_value(option) || option.get_positional()) {
        return text;
    }
    std::vector<std::string> more;
    if (option.get_required()) {
        more.emplace_back("required");
    }
    if (!option.get_default_str().empty()) {
        more.push_back("default: " + option.get_default_str());
    }
    if (const std::string range = range_words(option); !range.empty()) {
        more.push_back(range);
    }
    if (more.empty()) {
        return text;
    }
    const std::string words = pave::join(more);
    if (text.ends_with(")") && text.find("(default") != std::string::npos) {
        return text.substr(0, text.size() - 1) + ", " + words + ")";
    }
    return text + " (" + words + ")";
}

namespace {

class Layout : public CLI::Formatter {
public:
    explicit Layout(std::size_t columns) : columns_(columns) { column_width_ = std::min<std::size_t>(26, columns / 3); }

    std::string make_option(const CLI::Option* option, bool is_positional) const override {
        std::string name = make_option_name(option, is_positional);
        if (const std::size_t comma = name.find(",-"); comma != std::string::npos) {
            name.insert(comma + 1, " ");
        }
        if (!is_positional && takes_value(*option)) {
            name += " " + value_word(*option);
        }
        return entry(name, description_of(*option));
    }

    std::string make_subcommand(const CLI::App* command) const override {
        return entry(command->get_name(), command->get_description());
    }

    std::string make_description(const CLI::App* app) const override {
        return pave::join(report::wrapped(app->get_description(), columns_, 0), "\n") + "\n";
    }

private:
    std::string entry(const std::string& name, const std::string& words) const {
        std::string text = "  " + name;
        const std::string margin(column_width_, ' ');
        bool is_beside = text.size() + 2 <= column_width_;
        for (const std::string& line : report::wrapped(words, columns_ - column_width_, 0)) {
            text += is_beside ? std::string(column_width_ - text.size(), ' ') : "\n" + margin;
            text += line;
            is_beside = false;
        }
        return text + "\n";
    }

    std::size_t columns_;
};

} // namespace

std::shared_ptr<CLI::FormatterBase> help_in_columns(std::size_t columns) {
    return std::make_shared<Layout>(columns);
}

} // namespace explore::cli
