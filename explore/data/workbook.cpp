#include "data/workbook.h"

#include "base/error.h"
#include "data/csv.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <map>
#include <pugixml.hpp>
#include <sstream>
#include <unistd.h>
#include <xlsxwriter.h>
#include <zip.h>

namespace explore::data {

namespace {

constexpr std::size_t most_bytes = std::size_t{512} << 20U; // of one part: more is no table of drops

[[noreturn]] void refuse(const std::string& file, const std::string& why) {
    throw pave::Error({.file = file}, "this workbook cannot be read", why,
                      "a workbook of a spreadsheet (.xlsx), or CSV");
}

class Archive {
public:
    explicit Archive(const std::string& file) : file_(file), zip_(zip_open(file.c_str(), ZIP_RDONLY, nullptr)) {
        if (zip_ == nullptr) {
            refuse(file_, "the archive is damaged");
        }
    }
    ~Archive() { zip_discard(zip_); }
    Archive(const Archive&) = delete;
    Archive& operator=(const Archive&) = delete;

    bool has(const std::string& name) const { return zip_name_locate(zip_, name.c_str(), 0) >= 0; }

    pugi::xml_document part(const std::string& name) const {
        zip_stat_t about;
        if (zip_stat(zip_, name.c_str(), 0, &about) != 0 || (about.valid & ZIP_STAT_SIZE) == 0) {
            refuse(file_, "it has no " + name);
        }
        if (about.size > most_bytes) {
            refuse(file_, fmt::format("{} has {} MB", name, about.size >> 20U));
        }
        std::string text(about.size, '\0');
        zip_file_t* open = zip_fopen(zip_, name.c_str(), 0);
        const auto read = open == nullptr ? -1 : zip_fread(open, text.data(), text.size());
        if (open != nullptr) {
            zip_fclose(open);
        }
        pugi::xml_document document;
        if (read != static_cast<zip_int64_t>(text.size()) || !document.load_buffer(text.data(), text.size())) {
            refuse(file_, name + " is damaged");
        }
        return document;
    }

private:
    std::string file_;
    zip_t* zip_;
};

// Text of <t> and of the runs <r><t>.
std::string text_of(const pugi::xml_node& node) {
    std::string text = node.child("t").text().get();
    for (const pugi::xml_node& run : node.children("r")) {
        text += run.child("t").text().get();
    }
    return text;
}

// "BC12": column 54, row 11, from 0.
std::pair<std::size_t, std::size_t> place_of(std::string_view reference) {
    std::size_t column = 0;
    std::size_t at = 0;
    for (; at < reference.size() && reference[at] >= 'A' && reference[at] <= 'Z'; ++at) {
        column = 26 * column + static_cast<std::size_t>(reference[at] - 'A') + 1;
    }
    std::size_t row = 0;
    std::from_chars(reference.data() + at, reference.data() + reference.size(), row);
    return {std::max<std::size_t>(1, column) - 1, std::max<std::size_t>(1, row) - 1};
}

// A row is a line.
std::string cell_of(std::string text) {
    std::replace_if(
        text.begin(), text.end(), [](char c) { return c == '\n' || c == '\r'; }, ' ');
    return csv_cell(text);
}

std::string csv_of(const pugi::xml_document& sheet, const std::vector<std::string>& shared, const std::string& file) {
    std::string csv;
    std::size_t written = 0; // rows
    for (const pugi::xml_node& row : sheet.child("worksheet").child("sheetData").children("row")) {
        constexpr std::size_t most_rows = 1'048'576; // of a spreadsheet
        constexpr std::size_t most_columns = 16'384;
        const std::size_t at = row.attribute("r").as_ullong(written + 1) - 1;
        if (at >= most_rows || at < written) {
            refuse(file, "its rows are out of order");
        }
        csv.append(at - written, '\n');
        std::size_t cells = 0;
        for (const pugi::xml_node& cell : row.children("c")) {
            const auto reference = cell.attribute("r");
            const std::size_t column = reference ? place_of(reference.value()).first : cells;
            if (column >= most_columns || column < cells) {
                refuse(file, "its cells are out of order");
            }
            const std::string_view type = cell.attribute("t").value();
            std::string value = type == "inlineStr" ? text_of(cell.child("is")) : cell.child("v").text().get();
            if (type == "s") {
                const std::size_t index = cell.child("v").text().as_ullong(shared.size());
                value = index < shared.size() ? shared[index] : "";
            }
            csv.append(column - cells + (cells > 0 ? 1 : 0), ',');
            csv += cell_of(std::move(value));
            cells = column + 1;
        }
        csv += '\n';
        written = at + 1;
    }
    return csv;
}

} // namespace

std::optional<std::vector<Sheet>> sheets_of(const std::string& file) {
    const Archive archive(file);
    if (!archive.has("xl/workbook.xml")) {
        refuse(file, "the archive holds no workbook");
    }
    std::vector<std::string> shared;
    if (archive.has("xl/sharedStrings.xml")) {
        const pugi::xml_document strings = archive.part("xl/sharedStrings.xml");
        for (const pugi::xml_node& item : strings.child("sst").children("si")) {
            shared.push_back(text_of(item));
        }
    }
    std::map<std::string, std::string> targets; // of relations
    const pugi::xml_document relations = archive.part("xl/_rels/workbook.xml.rels");
    for (const pugi::xml_node& relation : relations.child("Relationships").children("Relationship")) {
        const std::string target = relation.attribute("Target").value();
        targets[relation.attribute("Id").value()] = target.starts_with('/') ? target.substr(1) : "xl/" + target;
    }
    std::vector<Sheet> sheets;
    const pugi::xml_document book = archive.part("xl/workbook.xml");
    for (const pugi::xml_node& sheet : book.child("workbook").child("sheets").children("sheet")) {
        const auto target = targets.find(sheet.attribute("r:id").value());
        if (target != targets.end() && archive.has(target->second)) {
            sheets.push_back({sheet.attribute("name").value(), csv_of(archive.part(target->second), shared, file)});
        }
    }
    return sheets;
}

std::optional<std::string> workbook_of(const std::string& csv, const std::string& sheet) {
    const auto path = std::filesystem::temp_directory_path() / fmt::format("pavescape-{}.xlsx", ::getpid());
    lxw_workbook* book = workbook_new(path.c_str());
    lxw_worksheet* page = workbook_add_worksheet(book, sheet.c_str());
    lxw_row_t row = 0;
    for (const CsvRow& read : parse_csv(csv, sheet, ',', Comments::none)) {
        for (std::size_t c = 0; c < read.cells.size(); ++c) {
            const std::string& cell = read.cells[c];
            double value = 0.0;
            const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
            const auto column = static_cast<lxw_col_t>(c);
            if (!cell.empty() && error == std::errc() && end == cell.data() + cell.size() && std::isfinite(value)) {
                worksheet_write_number(page, row, column, value, nullptr);
            } else if (!cell.empty()) {
                worksheet_write_string(page, row, column, cell.c_str(), nullptr);
            }
        }
        ++row;
    }
    const lxw_error failed = workbook_close(book);
    std::ostringstream bytes;
    bytes << std::ifstream(path, std::ios::binary).rdbuf();
    std::filesystem::remove(path);
    if (failed != LXW_NO_ERROR) {
        throw std::runtime_error(fmt::format("the workbook cannot be written: {}", lxw_strerror(failed)));
    }
    return bytes.str();
}

} // namespace explore::data
