#include "cli/help.h"

#include "base/text.h"
#include "cli/terminal.h"
#include "report/answer.h"

#include <algorithm>
#include <fmt/format.h>
#include <regex>
#include <unistd.h>

namespace explore::cli {
namespace {

bool takes_value(const CLI::Option& option) {
    return option.get_items_expected_max() > 0;
}

// The word that stands for the value of an option: DIR, N, {one,other}.
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

// "1 to 4096" of "INT:INT in [1 - 4096]" and of "FLOAT:1 - 4096"; empty: none is stated.
std::string range_words(const CLI::Option& option) {
    static const std::regex form(R"((?:INT in \[|FLOAT:)(-?[\d.e+]+) - (-?[\d.e+]+)\]?)");
    const std::string type = option.get_type_name();
    std::smatch found;
    return std::regex_search(type, found, form) ? fmt::format("{} to {}", found[1].str(), found[2].str()) : "";
}

// The description of the option with its range and its default.
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

std::string candidate(const std::string& word, const std::string& words) {
    return word + "\t" + words;
}

// The completions of the value of an option.
std::vector<std::string> values_of(const CLI::Option& option) {
    const std::vector<std::string> words = words_of(option);
    if (!words.empty()) {
        return words;
    }
    const std::string kind = value_word(option);
    if (kind == "DIR") {
        return {":folders"};
    }
    return kind.find("FILE") != std::string::npos ? std::vector<std::string>{":files"} : std::vector<std::string>();
}

// The completions of an argument that is no option.
std::vector<std::string> arguments_of(const CLI::Option& option) {
    const std::vector<std::string> words = words_of(option);
    if (!words.empty()) {
        return words;
    }
    const std::string name = option.get_name(true, false);
    if (name == "FIGURE") { // which lists them
        const std::string list = option.get_description();
        std::vector<std::string> figures = CLI::detail::split(list.substr(0, list.find(" (")), ',');
        std::transform(figures.begin(), figures.end(), figures.begin(),
                       [](const std::string& figure) { return CLI::detail::trim_copy(figure); });
        return figures;
    }
    const bool is_run = name == "RUN" || name == "FIRST" || name == "SECOND";
    return {name == "STUDY" || name == "OTHER" ? ":studies" : is_run ? ":folders" : ":files"};
}

} // namespace

std::shared_ptr<CLI::FormatterBase> help_in_columns(std::size_t columns) {
    return std::make_shared<Layout>(columns);
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

std::vector<std::string> completions(const CLI::App& app, const std::vector<std::string>& words) {
    std::vector<std::string> lines;
    if (words.empty()) {
        return lines;
    }
    const std::string& word = words.back();
    const auto offer = [&](const std::vector<std::string>& all) {
        std::copy_if(all.begin(), all.end(), std::back_inserter(lines),
                     [&](const std::string& line) { return line.starts_with(":") || line.starts_with(word); });
    };
    const auto options_of = [](const CLI::App& of) {
        std::vector<std::string> all;
        for (const CLI::Option* option : of.get_options()) {
            for (const std::string& name : option->get_lnames()) {
                all.push_back(candidate("--" + name, description_of(*option)));
            }
        }
        return all;
    };
    const auto commands = app.get_subcommands([](const CLI::App*) { return true; });
    if (words.size() == 1) {
        std::vector<std::string> all;
        for (const CLI::App* command : commands) {
            all.push_back(candidate(command->get_name(), command->get_description()));
        }
        offer(word.starts_with("-") ? options_of(app) : all);
        return lines;
    }
    const auto found = std::find_if(commands.begin(), commands.end(),
                                    [&](const CLI::App* command) { return command->get_name() == words[0]; });
    if (found == commands.end()) {
        return lines;
    }
    const CLI::App& command = **found;
    const CLI::Option* open = nullptr; // waits for its value
    std::size_t arguments = 0;
    for (std::size_t i = 1; i + 1 < words.size(); ++i) {
        if (words[i].starts_with("--")) {
            const CLI::Option* option = command.get_option_no_throw(words[i]);
            open = option != nullptr && takes_value(*option) ? option : nullptr;
        } else if (open != nullptr) {
            open = nullptr;
        } else {
            ++arguments;
        }
    }
    if (word.starts_with("-")) {
        offer(options_of(command));
    } else if (open != nullptr) {
        offer(values_of(*open));
    } else {
        const auto positionals = command.get_options([](const CLI::Option* o) { return o->get_positional(); });
        if (!positionals.empty()) { // the last may come several times
            offer(arguments_of(*positionals[std::min(arguments, positionals.size() - 1)]));
        }
    }
    return lines;
}

} // namespace explore::cli
