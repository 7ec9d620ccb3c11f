// An answer on the terminal: the verdict, the numbers, what to do next; the rest on request.
#pragma once

#include "report/json.h"

#include <string>
#include <vector>

namespace explore::report {

enum class Depth { verdict, brief, full };

struct Answer {
    std::string verdict;             // a sentence
    std::string heading;             // of the table
    std::vector<std::string> header; // of the table; empty: there is none
    std::vector<std::vector<std::string>> rows;
    std::vector<std::string> notes; // sentences, most important first
    std::string next;               // what to do, a line a step; a command ends its line
    std::string block;              // lines to paste into a file, shown as they are
    std::size_t lines = 25;         // of a brief answer, at most

    // The first sentence, and the others.
    void verdict_and_notes(std::vector<std::string> sentences);
};

inline constexpr std::size_t terminal_columns = 80;
inline constexpr std::size_t all_lines = 1'000'000; // of a brief answer that leaves nothing out

// Broken at spaces into lines of at most `columns` code points, a longer word too; those after the first indented.
std::vector<std::string> wrapped(const std::string& text, std::size_t columns, std::size_t indent);

// full: the page with everything; stands behind the verdict where depth is full, its sentences wrapped and its tables
// folded. No line is longer than `columns` but for commands, which are pasted from one; what does not fit into the
// lines of a brief answer is counted. colour: of the verdict.
std::string laid_out(const Answer& answer, Depth depth, const std::string& full, bool colour,
                     std::size_t columns = terminal_columns);

// Of what a command keeps as NAME.json (fit, unique, diagnose, survey, road, sample).
Answer answer_of(const std::string& command, const Json& json);

} // namespace explore::report
