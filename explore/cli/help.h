// `--help`, and the words that complete a command line: both from the options as the commands declare them.
#pragma once

#include <CLI/CLI.hpp>
#include <memory>
#include <string>
#include <vector>

namespace explore::cli {

// Lays `--help` out in so many columns: a word for the value of each option, its range and its default behind what it
// does. Commands to paste stand in one line, however long.
std::shared_ptr<CLI::FormatterBase> help_in_columns(std::size_t columns);

bool takes_value(const CLI::Option& option);
// The words that an option takes; empty: any.
std::vector<std::string> words_of(const CLI::Option& option);
// The word that stands for the value of an option: DIR, N, {one,other}.
std::string value_word(const CLI::Option& option);
// The description of the option with its range and its default.
std::string description_of(const CLI::Option& option);

// The completions of the last of these words, which follow the program's name: one line for each candidate, its
// explanation behind a tab; `:files`, `:studies` and `:folders` stand for names from the disk.
std::vector<std::string> completions(const CLI::App& app, const std::vector<std::string>& words);

} // namespace explore::cli
