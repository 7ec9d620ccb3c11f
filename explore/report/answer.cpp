#include "report/answer.h"

#include "base/error.h"
#include "report/table.h"

#include <algorithm>
#include <fmt/format.h>
#include <set>

namespace explore::report {
namespace {

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

std::string trimmed(std::string line) {
    line.erase(line.find_last_not_of(' ') + 1);
    return line;
}

// A row of a table: its cells stand apart by two blanks or more.
bool is_row(const std::string& line) {
    const std::size_t begin = line.find_first_not_of(' ');
    return begin != std::string::npos && line.find("  ", begin) != std::string::npos;
}

// One code point an entry.
std::vector<std::string> glyphs_of(const std::string& text) {
    std::vector<std::string> glyphs;
    for (const char c : text) {
        if (glyphs.empty() || (static_cast<unsigned char>(c) & 0xc0U) != 0x80U) {
            glyphs.emplace_back();
        }
        glyphs.back() += c;
    }
    return glyphs;
}

// Rows that are too wide, cut between columns into tables below each other; each begins with the first columns, as many
// as tell the rows apart.
class FoldedTable {
public:
    FoldedTable(const std::vector<std::string>& rows, std::size_t columns) : columns_(columns) {
        for (const std::string& row : rows) {
            rows_.push_back(glyphs_of(row));
            wide_ = std::max(wide_, rows_.back().size());
        }
        for (std::size_t c = 0; c < wide_; ++c) {
            if (!is_blank(c) && (c < gap || (is_blank(c - 1) && is_blank(c - 2)))) {
                begins_.push_back(c);
            }
        }
        begins_.push_back(wide_ + gap);
    }

    std::vector<std::string> lines() const {
        std::vector<std::string> lines;
        const std::size_t columns = begins_.size() - 1;
        constexpr std::size_t least_name = 24;
        const std::size_t others = columns > 1 ? wide_ - begins_[1] : columns_; // the width of all but the first
        if (columns > 1 && begins_[1] > columns_ / 2 && others + least_name <= columns_) {
            return with_narrow_names(columns_ - others);
        }
        std::size_t named = 1;
        while (named + 1 < columns && begins_[named + 1] <= columns_ / 2 && !tells_apart(named)) {
            ++named;
        }
        const std::size_t name = columns > 1 ? begins_[named] : 0; // the width of the first columns
        const std::size_t most = name > columns_ / 2 ? 0 : columns_ - name;
        for (std::size_t from = named, to = named; from < columns; from = to) {
            for (to = from + 1; to < columns && begins_[to + 1] - gap - begins_[from] <= most;) {
                ++to;
            }
            if (from > named && is_empty(begins_[from], begins_[to])) {
                continue;
            }
            if (from > named) {
                lines.emplace_back("");
            }
            for (std::size_t r = 0; r < rows_.size(); ++r) {
                const std::string cells = trimmed(part(r, begins_[from], begins_[to]));
                if (cells.empty() && from > named) {
                    continue;
                }
                const std::string own = part(r, 0, name);
                if (most > 0 && width(cells) <= most) {
                    lines.push_back(trimmed(own + cells));
                } else if (most > 0) { // a column of sentences
                    const auto words = wrapped(cells, most, 0);
                    for (std::size_t i = 0; i < words.size(); ++i) {
                        lines.push_back((i == 0 ? own + std::string(name - width(own), ' ') : std::string(name, ' ')) +
                                        words[i]);
                    }
                } else {
                    const auto words = wrapped(own + cells, columns_ - 2, 2);
                    for (const std::string& line : words) {
                        lines.push_back("  " + line);
                    }
                }
            }
        }
        return lines;
    }

private:
    static constexpr std::size_t gap = 2;

    // The first column wrapped to this width, the gap behind it included.
    std::vector<std::string> with_narrow_names(std::size_t name) const {
        std::vector<std::string> lines;
        const std::string margin(begins_[0], ' ');
        for (std::size_t r = 0; r < rows_.size(); ++r) {
            const auto words = wrapped(trimmed(part(r, begins_[0], begins_[1])), name - gap - margin.size(), 2);
            const std::string own = margin + (words.empty() ? "" : words[0]);
            lines.push_back(trimmed(own + std::string(name - width(own), ' ') + part(r, begins_[1], wide_)));
            for (std::size_t i = 1; i < words.size(); ++i) {
                lines.push_back(margin + words[i]);
            }
        }
        return lines;
    }

    bool is_blank(std::size_t column) const {
        return std::all_of(rows_.begin(), rows_.end(),
                           [&](const auto& row) { return column >= row.size() || row[column] == " "; });
    }
    // Below the header.
    bool is_empty(std::size_t from, std::size_t to) const {
        for (std::size_t r = 1; r < rows_.size(); ++r) {
            if (!trimmed(part(r, from, to)).empty()) {
                return false;
            }
        }
        return rows_.size() > 1;
    }
    bool tells_apart(std::size_t columns) const {
        std::set<std::string> names;
        for (std::size_t r = 0; r < rows_.size(); ++r) {
            names.insert(part(r, 0, begins_[columns]));
        }
        return names.size() == rows_.size();
    }
    std::string part(std::size_t row, std::size_t from, std::size_t to) const {
        std::string text;
        for (std::size_t c = from; c < std::min(to, rows_[row].size()); ++c) {
            text += rows_[row][c];
        }
        return text;
    }

    std::size_t columns_; // of the terminal
    std::vector<std::vector<std::string>> rows_;
    std::vector<std::size_t> begins_; // of the columns, then where another would begin
    std::size_t wide_ = 0;
};

// A page in the width of the terminal: sentences wrapped, tables folded.
std::string in_columns(const std::string& page, std::size_t columns) {
    const std::vector<std::string> all = lines_of(page);
    std::string text;
    for (std::size_t i = 0; i < all.size();) {
        std::size_t end = i;
        bool is_wide = false;
        while (end < all.size() && is_row(all[end])) {
            is_wide = is_wide || width(all[end]) > columns;
            ++end;
        }
        std::vector<std::string> lines;
        if (end > i) {
            lines.assign(all.begin() + static_cast<std::ptrdiff_t>(i), all.begin() + static_cast<std::ptrdiff_t>(end));
            if (is_wide) {
                lines = FoldedTable(lines, columns).lines();
            }
        } else {
            end = i + 1;
            lines = {all[i]};
            if (width(all[i]) > columns) {
                const std::size_t indent = all[i].find_first_not_of(' ');
                const std::size_t command = all[i].find("pavescape "); // which is pasted from one line
                lines = wrapped(all[i].substr(0, command), columns - indent, 2);
                if (command != std::string::npos) {
                    lines.push_back("  " + all[i].substr(command));
                }
                for (std::string& line : lines) {
                    line.insert(0, indent, ' ');
                }
            }
        }
        text += pave::join(lines, "\n") + "\n";
        i = end;
    }
    return text;
}

std::string more(std::size_t count) {
    return fmt::format("  ... and {} more (--verbose)", count);
}

// Words are cut where the table is too wide for them, first those of the header; where it still is its last columns are
// left out, with a mark.
std::vector<std::string> table_lines(const Answer& answer, std::size_t rows, std::size_t terminal) {
    const auto lines_with = [&](std::size_t columns, std::size_t name_columns, std::size_t cell_columns) {
        const auto cut = [&](std::vector<std::string> row, const char* mark) {
            const bool is_left_out = columns < answer.header.size();
            row.resize(columns);
            for (std::size_t c = 0; c < row.size(); ++c) {
                const std::size_t limit = c == 0 ? name_columns : cell_columns;
                if (width(row[c]) > limit) {
                    row[c] = head(row[c], limit - 2) + "..";
                }
            }
            if (is_left_out) {
                row.emplace_back(mark);
            }
            return row;
        };
        Table table(cut(answer.header, "..."));
        for (std::size_t i = 0; i < rows; ++i) {
            table.add(cut(answer.rows[i], ""));
        }
        return lines_of(table.text());
    };
    const auto fits = [&](const std::vector<std::string>& lines) {
        return std::all_of(lines.begin(), lines.end(),
                           [&](const std::string& line) { return width(line) <= terminal; });
    };
    struct Widths {
        std::size_t name, cell;
    };
    std::vector<std::string> lines;
    for (std::size_t columns = answer.header.size(); columns > 0; --columns) {
        for (const auto& [name, cell] :
             {Widths{terminal, terminal}, {30, 24}, {30, 14}, {30, 12}, {30, 10}, {20, 10}}) {
            lines = lines_with(columns, name, cell); // a number takes ten at most
            if (fits(lines)) {
                return lines;
            }
        }
    }
    return lines;
}

// A line a step; a command that does not fit beside its words stands below them, in one line.
std::vector<std::string> next_lines(const std::string& next, std::size_t columns) {
    constexpr std::string_view opening = "Next: ";
    const std::string margin(opening.size(), ' ');
    std::vector<std::string> lines;
    for (const std::string& step : lines_of(next)) {
        std::string begin = lines.empty() ? std::string(opening) : margin;
        if (width(begin + step) <= columns) {
            lines.push_back(begin + step);
            continue;
        }
        const std::size_t command = step.find("pavescape ");
        for (const std::string& part : wrapped(step.substr(0, command), columns - margin.size(), 0)) {
            lines.push_back(begin + part);
            begin = margin;
        }
        if (command != std::string::npos) {
            if (lines.empty()) {
                lines.push_back(trimmed(begin));
            }
            lines.push_back("  " + step.substr(command));
        }
    }
    return lines;
}

} // namespace

void Answer::verdict_and_notes(std::vector<std::string> sentences) {
    notes = std::move(sentences);
    if (!notes.empty()) {
        verdict = std::move(notes.front());
        notes.erase(notes.begin());
    }
}

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

std::string laid_out(const Answer& answer, Depth depth, const std::string& full, bool colour, std::size_t columns) {
    constexpr std::size_t of_verdict = 5;
    std::vector<std::string> verdict = wrapped(answer.verdict, columns, 0);
    if (depth == Depth::brief && verdict.size() > of_verdict) {
        verdict.resize(of_verdict);
        verdict.back() = head(verdict.back(), columns - 4) + " ...";
    }
    std::string text = pave::join(verdict, "\n");
    text = (colour ? "\033[1;36m" + text + "\033[0m" : text) + "\n";
    if (depth == Depth::verdict) {
        return text;
    }
    if (depth == Depth::full) {
        return text + "\n" + in_columns(full, columns);
    }
    const std::vector<std::string> next =
        answer.next.empty() ? std::vector<std::string>() : next_lines(answer.next, columns);
    std::size_t left = answer.lines - std::min(answer.lines, verdict.size() + next.size() + 2);
    std::vector<std::string> body;
    if (!answer.header.empty() && left > 6) {
        constexpr std::size_t kept_for_notes = 7;
        const std::size_t room = left - 3 - std::min<std::size_t>(left - 4, answer.notes.empty() ? 0 : kept_for_notes);
        const std::size_t rows = answer.rows.size() <= room ? answer.rows.size() : room - 1;
        body.emplace_back("");
        body.push_back(head(answer.heading, columns));
        const auto table = table_lines(answer, rows, columns);
        body.insert(body.end(), table.begin(), table.end());
        if (rows < answer.rows.size()) {
            body.push_back(more(answer.rows.size() - rows));
        }
        left -= std::min(left, body.size());
    }
    std::vector<std::string> notes;
    std::size_t said = 0;
    for (const std::string& note : answer.notes) {
        const auto lines = wrapped("- " + note, columns, 2);
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
    return text + (answer.block.empty() ? "" : "\n" + answer.block);
}

} // namespace explore::report
