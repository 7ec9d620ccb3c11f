// The words that complete a command line.
#include "cli/help.h"

#include <algorithm>
#include <iterator>

namespace explore::cli {
namespace {

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
