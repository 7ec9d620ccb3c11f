// Text tables for people.
#pragma once

#include <string>
#include <vector>

namespace explore::report {

// Code points of a text: the columns that it takes.
std::size_t width(const std::string& text);

// Columns are as wide as their widest cell (counted in code points); numbers right, words left.
class Table {
public:
    explicit Table(std::vector<std::string> header) : rows_{std::move(header)} {}
    void add(std::vector<std::string> row) { rows_.push_back(std::move(row)); }
    std::string text(int indent = 2) const;

private:
    std::vector<std::vector<std::string>> rows_;
};

// A row of blocks, lowest value lowest; not-a-number is a space.
std::string sparkline(const std::vector<double>& values);

} // namespace explore::report
