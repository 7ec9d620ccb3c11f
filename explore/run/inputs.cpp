#include "run/inputs.h"

#include "data/hash.h"
#include "run/files.h"

#include <SQLiteCpp/SQLiteCpp.h>
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>

namespace explore::run {
namespace {

// Contents once each.
constexpr const char* schema_of_inputs = R"(
CREATE TABLE IF NOT EXISTS content (
    hash TEXT PRIMARY KEY,
    bytes BLOB NOT NULL
);
CREATE TABLE IF NOT EXISTS input (
    session INTEGER NOT NULL REFERENCES session (id),
    number INTEGER NOT NULL,
    path TEXT NOT NULL,
    study_hash TEXT NOT NULL,
    content TEXT NOT NULL REFERENCES content (hash),
    PRIMARY KEY (session, path)
);
)";

} // namespace

void Inputs::add(const std::string& study_hash, const std::vector<data::InputFile>& files) {
    for (const data::InputFile& file : files) {
        if (std::none_of(inputs_.begin(), inputs_.end(),
                         [&](const Input& old) { return old.file.path == file.path; })) {
            inputs_.push_back({&file == files.data() ? study_hash : std::string(), file});
        }
    }
}

void Inputs::write(SQLite::Database& database, std::int64_t session) {
    for (; written_ < inputs_.size(); ++written_) {
        const auto& [study_hash, file] = inputs_[written_];
        const std::string hash = data::hash_of(file.bytes);
        SQLite::Statement content(database, "INSERT OR IGNORE INTO content (hash, bytes) VALUES (?, ?)");
        content.bind(1, hash);
        content.bind(2, file.bytes.data(), static_cast<int>(file.bytes.size()));
        content.exec();
        SQLite::Statement input(database, "INSERT OR IGNORE INTO input (session, number, path, study_hash, content) "
                                          "VALUES (?, ?, ?, ?, ?)");
        input.bind(1, session);
        input.bind(2, static_cast<std::int64_t>(written_));
        input.bind(3, file.path);
        input.bind(4, study_hash);
        input.bind(5, hash);
        input.exec();
    }
}

void make_input_tables(SQLite::Database& database) {
    database.exec(schema_of_inputs);
}

std::vector<data::InputFile> inputs_of(const SQLite::Database& database, std::int64_t session) {
    SQLite::Statement row(database, "SELECT path, bytes FROM input JOIN content ON content = hash "
                                    "WHERE session = ? ORDER BY number");
    row.bind(1, session);
    std::vector<data::InputFile> files;
    while (row.executeStep()) {
        files.push_back({row.getColumn(0).getString(), row.getColumn(1).getString()});
    }
    return files;
}

std::optional<std::string> study_text_of(const SQLite::Database& database, const std::string& study_hash) {
    SQLite::Statement row(database, "SELECT bytes FROM input JOIN content ON content = hash "
                                    "WHERE study_hash = ? ORDER BY session DESC, number");
    row.bind(1, study_hash);
    return row.executeStep() ? std::optional(row.getColumn(0).getString()) : std::nullopt;
}

Start laid_out(Start start, const std::vector<data::InputFile>& inputs, const std::string& root) {
    namespace fs = std::filesystem;
    if (inputs.empty()) {
        return start;
    }
    const fs::path directory = start.directory;
    const auto below = [&](const fs::path& path) {
        return fs::path(root) / (directory / path).lexically_normal().relative_path();
    };
    start.directory = below("").string();
    fs::create_directories(start.directory);
    for (const data::InputFile& input : inputs) {
        const fs::path path = below(input.path);
        fs::create_directories(path.parent_path());
        write_file(path.parent_path().string(), path.filename().string(), input.bytes);
        std::ifstream now(directory / input.path, std::ios::binary);
        const std::string bytes{std::istreambuf_iterator<char>(now), {}};
        start.changed = start.changed || !now || bytes != input.bytes;
        if (!fs::path(input.path).is_absolute()) {
            continue;
        }
        for (std::string& argument : start.arguments) {
            if (argument == input.path) {
                argument = path.string();
            } else if (argument.ends_with("=" + input.path)) { // --study=PATH
                argument.replace(argument.size() - input.path.size(), input.path.size(), path.string());
            }
        }
    }
    return start;
}

} // namespace explore::run
