#include "report/answer.h"

#include "base/error.h"
#include "report/table.h"

#include <algorithm>
#include <fmt/format.h>

namespace explore::report {
namespace {

std::size_t width(const std::string& text) {
    return static_cast<std::size_t>(std::count_if(
        text.begin(), text.end(), [](char c) { return (static_cast<unsigned char>(c) & 0xc0U) != 0x80U; }));
}

// The first `columns` code points.
std::string head(const std::string& text, std::size_t columns) {
    std::size_t bytes = 0;
    for (std::size_t seen = 0; bytes < text.size(); ++bytes) {
        const bool begins = (static_cast<unsigned char>(text[bytes]) & 0xc0U) != 0x80U;
        if (begins && seen++ == columns) {
            break;
        }
    }
    return text.substr(0, bytes);
}

std::vector<std::string> lines_of(const std::string& text) {
    std::vector<std::string> lines;
    for (std::size_t begin = 0; begin < text.size();) {
        const std::size_t end = std::min(text.find('\n', begin), text.size());
        lines.push_back(text.substr(begin, end - begin));
        begin = end + 1;
    }
    return lines;
}

std::string more(std::size_t count) {
    return fmt::format("  ... and {} more (--verbose)", count);
}

// Cells are cut, from the first column on, until the table fits.
std::vector<std::string> table_lines(const Answer& answer, std::size_t rows) {
    constexpr std::size_t name_columns = 30;
    constexpr std::size_t cell_columns = 14;
    const auto cut = [&](std::vector<std::string> row) {
        for (std::size_t c = 0; c < row.size(); ++c) {
            const std::size_t limit = c == 0 ? name_columns : cell_columns;
            if (width(row[c]) > limit) {
                row[c] = head(row[c], limit - 2) + "..";
            }
        }
        return row;
    };
    Table table(cut(answer.header));
    for (std::size_t i = 0; i < rows; ++i) {
        table.add(cut(answer.rows[i]));
    }
    std::vector<std::string> lines = lines_of(table.text());
    for (std::string& line : lines) {
        line = head(line, terminal_columns);
    }
    return lines;
}

} // namespace

std::vector<std::string> wrapped(const std::string& text, std::size_t columns, std::size_t indent) {
    const std::string margin(indent, ' ');
    std::vector<std::string> lines;
    std::string line;
    const auto end_line = [&] {
        lines.push_back(line);
        line = margin;
    };
    for (std::size_t begin = 0; begin < text.size();) {
        const std::size_t end = std::min(text.find(' ', begin), text.size());
        std::string word = text.substr(begin, end - begin);
        begin = end + 1;
        if (word.empty()) {
            continue;
        }
        const bool is_first = line.find_first_not_of(' ') == std::string::npos;
        if (!is_first && width(line) + 1 + width(word) > columns) {
            end_line();
        } else if (!is_first) {
            line += ' ';
        }
        while (width(line) + width(word) > columns) {
            const std::string part = head(word, columns - width(line));
            line += part;
            word.erase(0, part.size());
            end_line();
        }
        line += word;
    }
    if (line.find_first_not_of(' ') != std::string::npos) {
        lines.push_back(line);
    }
    return lines;
}

std::string laid_out(const Answer& answer, Depth depth, const std::string& full, bool colour) {
    constexpr std::size_t of_verdict = 5;
    std::vector<std::string> verdict = wrapped(answer.verdict, terminal_columns, 0);
    if (depth == Depth::brief && verdict.size() > of_verdict) {
        verdict.resize(of_verdict);
        verdict.back() = head(verdict.back(), terminal_columns - 4) + " ...";
    }
    std::string text = pave::join(verdict, "\n");
    text = (colour ? "\033[1;36m" + text + "\033[0m" : text) + "\n";
    if (depth == Depth::verdict) {
        return text;
    }
    if (depth == Depth::full) {
        return text + "\n" + full;
    }
    const std::vector<std::string> next =
        answer.next.empty() ? std::vector<std::string>() : wrapped("Next: " + answer.next, terminal_columns, 6);
    std::size_t left = answer.lines - std::min(answer.lines, verdict.size() + next.size() + 2);
    std::vector<std::string> body;
    if (!answer.header.empty() && left > 6) {
        constexpr std::size_t kept_for_notes = 7;
        const std::size_t room = left - 3 - std::min<std::size_t>(left - 4, answer.notes.empty() ? 0 : kept_for_notes);
        const std::size_t rows = answer.rows.size() <= room ? answer.rows.size() : room - 1;
        body.emplace_back("");
        body.push_back(head(answer.heading, terminal_columns));
        const auto table = table_lines(answer, rows);
        body.insert(body.end(), table.begin(), table.end());
        if (rows < answer.rows.size()) {
            body.push_back(more(answer.rows.size() - rows));
        }
        left -= std::min(left, body.size());
    }
    std::vector<std::string> notes;
    std::size_t said = 0;
    for (const std::string& note : answer.notes) {
        const auto lines = wrapped("- " + note, terminal_columns, 2);
        const bool is_last = said + 1 == answer.notes.size();
        if (notes.size() + lines.size() + (is_last ? 1 : 2) > left) {
            break; // those behind it matter less
        }
        notes.insert(notes.end(), lines.begin(), lines.end());
        ++said;
    }
    if (said < answer.notes.size()) {
        notes.push_back(more(answer.notes.size() - said));
    }
    if (!notes.empty()) {
        body.emplace_back("");
        body.insert(body.end(), notes.begin(), notes.end());
    }
    for (const std::string& line : body) {
        text += line + "\n";
    }
    if (!next.empty()) {
        text += "\n" + pave::join(next, "\n") + "\n";
    }
    return text;
}

} // namespace explore::report
