// The files that the sessions of a store read, kept in it as they were.
#pragma once

#include "data/csv.h"

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace SQLite {
class Database;
}

namespace explore::run {

// The inputs that one process reads: in memory until its session stands in the store.
class Inputs {
public:
    // study_hash: of the study whose file is the first; may be empty. A path that is known already is left out.
    void add(const std::string& study_hash, const std::vector<data::InputFile>& files);
    // Those that are not in the database yet, under this session. Within the transaction of the caller.
    void write(SQLite::Database& database, std::int64_t session);

private:
    struct Input {
        std::string study_hash; // of a study's own file
        data::InputFile file;
    };
    std::vector<Input> inputs_;
    std::size_t written_ = 0;
};

// Stores of programs before have no such tables.
void make_input_tables(SQLite::Database& database);

std::vector<data::InputFile> inputs_of(const SQLite::Database& database, std::int64_t session);
// The text of a study with this hash, as it was last run; nothing: not kept.
std::optional<std::string> study_text_of(const SQLite::Database& database, const std::string& study_hash);

// A command line and the folder that it is started in.
struct Start {
    std::vector<std::string> arguments;
    std::string directory;
    bool changed = false; // a file is no longer what was read
};

// The command line for the same files, which are laid out anew below `root` in folders of the same names: what it does
// there does not depend on what became of them. Without files: as it was.
Start laid_out(Start start, const std::vector<data::InputFile>& inputs, const std::string& root);

} // namespace explore::run
