#include "run/store.h"

#include "base/error.h"
#include "run/inputs.h"

#include <SQLiteCpp/SQLiteCpp.h>
#include <chrono>
#include <cstring>
#include <filesystem>
#include <fmt/format.h>
#include <limits>
#include <nlohmann/json.hpp>
#include <sqlite3.h>
#include <thread>

namespace explore::run {
namespace {

constexpr int application_id = 0x50617665; // "Pave"

constexpr const char* schema = R"(
CREATE TABLE run (
    id INTEGER PRIMARY KEY,
    command TEXT NOT NULL,
    study_hash TEXT NOT NULL,
    settings TEXT NOT NULL,
    version TEXT NOT NULL,
    header TEXT NOT NULL,
    used INTEGER NOT NULL,
    result TEXT,
    UNIQUE (command, study_hash, settings)
);
CREATE TABLE evaluation (
    run INTEGER NOT NULL REFERENCES run (id),
    start INTEGER NOT NULL,
    number INTEGER NOT NULL,
    status INTEGER NOT NULL,
    reason TEXT NOT NULL,
    parameters BLOB NOT NULL,
    responses BLOB NOT NULL,
    jacobian BLOB NOT NULL,
    warnings TEXT NOT NULL,
    misfit REAL,
    in_place_of_reduced INTEGER NOT NULL,
    PRIMARY KEY (run, start, number)
) WITHOUT ROWID;
CREATE TABLE session (
    id INTEGER PRIMARY KEY,
    version TEXT NOT NULL,
    libraries TEXT NOT NULL,
    arguments TEXT NOT NULL,
    directory TEXT NOT NULL,
    threads INTEGER NOT NULL,
    began TEXT NOT NULL,
    seconds REAL NOT NULL,
    evaluations INTEGER NOT NULL
);
)";

void bind_doubles(SQLite::Statement& statement, int index, const double* data, std::size_t count) {
    // An empty blob, not NULL, where there is nothing.
    statement.bind(index, count > 0 ? static_cast<const void*>(data) : "", static_cast<int>(count * sizeof(double)));
}

std::vector<double> doubles(const SQLite::Column& column) {
    std::vector<double> values(static_cast<std::size_t>(column.getBytes()) / sizeof(double));
    if (!values.empty()) {
        std::memcpy(values.data(), column.getBlob(), values.size() * sizeof(double));
    }
    return values;
}

// How many numbers the evaluations of a run hold.
struct Shape {
    std::size_t parameters = 0, responses = 0;
};

// A complaint about what a cell holds; guarded() adds the file.
struct Damage {
    std::string what;
};

void fill_header(RunHeader& header, const std::string& text) {
    const auto columns = nlohmann::json::parse(text, nullptr, false);
    try {
        header.parameters = columns.at("parameters").get<std::vector<std::string>>();
        header.responses = columns.at("responses").get<std::vector<std::string>>();
        header.response_to_si = columns.at("response_to_si").get<std::vector<double>>();
    } catch (const nlohmann::json::exception&) {
        throw Damage{"the list of parameters and responses"};
    }
    if (header.response_to_si.size() != header.responses.size()) {
        throw Damage{"the units of the responses"};
    }
}

std::vector<std::string> arguments_of(const std::string& text) {
    try {
        return nlohmann::json::parse(text).get<std::vector<std::string>>();
    } catch (const nlohmann::json::exception&) {
        throw Damage{"the arguments of a command"};
    }
}

problem::Evaluation evaluation_of(SQLite::Statement& row, int first, Shape shape) {
    problem::Evaluation e;
    const int status = row.getColumn(first).getInt();
    if (status < 0 || status >= static_cast<int>(std::size(pave::all_statuses))) {
        throw Damage{"the status of an evaluation"};
    }
    e.status = static_cast<pave::Status>(status);
    e.reason = row.getColumn(first + 1).getString();
    e.parameters = doubles(row.getColumn(first + 2));
    e.responses = doubles(row.getColumn(first + 3));
    const auto jacobian = doubles(row.getColumn(first + 4));
    if (e.parameters.size() != shape.parameters ||
        (e.responses.size() != shape.responses && (e.converged() || !e.responses.empty())) ||
        (!jacobian.empty() && jacobian.size() != shape.parameters * shape.responses)) {
        throw Damage{"the numbers of an evaluation"};
    }
    if (!jacobian.empty()) {
        const auto columns = static_cast<Eigen::Index>(e.parameters.size());
        e.jacobian = Eigen::Map<const Eigen::MatrixXd>(jacobian.data(),
                                                       static_cast<Eigen::Index>(jacobian.size()) / columns, columns);
    }
    const std::string warnings = row.getColumn(first + 5).getString();
    for (std::size_t at = 0; at < warnings.size();) {
        const std::size_t end = std::min(warnings.find('\n', at), warnings.size());
        e.warnings.push_back(warnings.substr(at, end - at));
        at = end + 1;
    }
    if (!row.getColumn(first + 6).isNull()) {
        e.misfit = row.getColumn(first + 6).getDouble();
    }
    e.in_place_of_reduced = row.getColumn(first + 7).getInt() != 0;
    return e;
}

constexpr const char* select_columns =
    "SELECT start, number, status, reason, parameters, responses, jacobian, warnings, misfit, "
    "in_place_of_reduced FROM evaluation WHERE ";

} // namespace

struct Store::Implementation {
    std::string file;
    SQLite::Database database;
    std::unique_ptr<SQLite::Statement> insert, count;
    std::optional<Session> session;
    std::chrono::steady_clock::time_point opened;
    Inputs inputs{};             // of this session
    std::int64_t session_id = 0; // 0: not yet in the file

    // The write-ahead log. SQLite does not wait for another process that is about to ask for the same.
    void use_log() {
        for (int attempt = 0;; ++attempt) {
            try {
                database.exec("PRAGMA journal_mode = WAL");
                return;
            } catch (const SQLite::Exception& error) {
                if (error.getErrorCode() != SQLITE_BUSY || attempt == 1000) {
                    throw;
                }
                std::this_thread::sleep_for(std::chrono::milliseconds(10));
            }
        }
    }

    Shape shape_of(int run) const {
        SQLite::Statement row(database, "SELECT header FROM run WHERE id = ?");
        row.bind(1, run);
        if (!row.executeStep()) {
            throw Damage{"no run of this number"};
        }
        RunHeader header;
        fill_header(header, row.getColumn(0).getString());
        return {header.parameters.size(), header.responses.size()};
    }

    // SQLite's own words, as a complaint about the file.
    template <class F>
    auto guarded(F f) const {
        try {
            return f();
        } catch (const Damage& damage) {
            throw pave::Error({.file = file}, "the run store is damaged", damage.what, "another folder (--out)");
        } catch (const SQLite::Exception& error) {
            const int code = error.getErrorCode();
            if (code == SQLITE_FULL || code == SQLITE_IOERR) { // nothing is wrong with what the user wrote
                throw std::runtime_error(fmt::format(
                    "{}: no room to keep what is computed: {}; what was finished is kept", file, error.what()));
            }
            const bool no_store = code == SQLITE_NOTADB || code == SQLITE_CORRUPT;
            throw pave::Error({.file = file}, no_store ? "this is not a run store" : "the run store cannot be used",
                              error.what(), no_store ? "another folder (--out)" : "a folder that can be written");
        }
    }
};

Store::Store(const std::string& folder) : Store(folder, std::optional<Session>()) {}

Store::Store(const std::string& folder, Session session) : Store(folder, std::optional(std::move(session))) {}

Store::Store(const std::string& folder, std::optional<Session> session) {
    const bool create = session.has_value();
    const std::string file = (std::filesystem::path(folder) / "run.sqlite").string();
    if (create) {
        std::error_code error;
        std::filesystem::create_directories(folder, error);
        if (error) {
            throw pave::Error({.file = folder}, "the folder for results cannot be made", error.message(),
                              "a folder that can be written (--out)");
        }
    } else if (!std::filesystem::exists(file)) {
        throw pave::Error({.file = folder}, "there is no run here", "no file run.sqlite",
                          "the folder of a run, for example output/NAME");
    }
    try {
        implementation_ = std::unique_ptr<Implementation>(new Implementation{
            file, SQLite::Database(file, SQLite::OPEN_READWRITE | (create ? SQLite::OPEN_CREATE : 0), 10000), nullptr,
            nullptr, std::move(session), std::chrono::steady_clock::now()});
    } catch (const SQLite::Exception& error) {
        throw pave::Error({.file = file}, "the run store cannot be opened", error.what(),
                          "a folder that can be written (--out)");
    }
    auto& m = *implementation_;
    m.guarded([&] {
        const auto has_nothing = [&] {
            return m.database.execAndGet("SELECT count(*) FROM sqlite_master").getInt() == 0;
        };
        int id = 0;
        int version = 0;
        bool is_new = false;
        { // one look: another process may be making the store
            SQLite::Transaction look(m.database, SQLite::TransactionBehavior::DEFERRED);
            is_new = has_nothing();
            id = m.database.execAndGet("PRAGMA application_id").getInt();
            version = m.database.execAndGet("PRAGMA user_version").getInt();
        }
        if (!is_new && (id != application_id || version != format_version)) {
            throw pave::Error({.file = file}, "this store is not of this program's format",
                              fmt::format("application {:#x}, version {}", id, version),
                              fmt::format("version {}; use another folder (--out)", format_version));
        }
        // Each evaluation is a transaction of its own in the write-ahead log: ending the process loses none, and a
        // power cut loses at most the last ones.
        m.use_log();
        m.database.exec("PRAGMA synchronous = NORMAL");
        if (is_new) {
            SQLite::Transaction transaction(m.database, SQLite::TransactionBehavior::IMMEDIATE);
            if (has_nothing()) { // another process may have been faster
                m.database.exec(schema);
                m.database.exec(fmt::format("PRAGMA application_id = {}", application_id));
                m.database.exec(fmt::format("PRAGMA user_version = {}", format_version));
            }
            transaction.commit();
        }
        make_input_tables(m.database);
        m.insert = std::make_unique<SQLite::Statement>(
            m.database, "INSERT OR IGNORE INTO evaluation (run, start, number, status, reason, parameters, responses, "
                        "jacobian, warnings, misfit, in_place_of_reduced) VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)");
        if (m.session) {
            m.session->began = m.database.execAndGet("SELECT strftime('%Y-%m-%dT%H:%M:%SZ', 'now')").getString();
        }
    });
}

Store::~Store() = default;

int Store::begin(const RunHeader& header) {
    const std::scoped_lock lock(mutex_);
    auto& m = *implementation_;
    return m.guarded([&] {
        SQLite::Transaction transaction(m.database, SQLite::TransactionBehavior::IMMEDIATE);
        const nlohmann::json columns = {{"parameters", header.parameters},
                                        {"responses", header.responses},
                                        {"response_to_si", header.response_to_si}};
        SQLite::Statement add(m.database, "INSERT OR IGNORE INTO run (command, study_hash, settings, version, header, "
                                          "used) VALUES (?, ?, ?, ?, ?, 0)");
        add.bind(1, header.key.command);
        add.bind(2, header.key.study_hash);
        add.bind(3, header.key.settings);
        add.bind(4, header.version);
        add.bind(5, columns.dump());
        add.exec();
        SQLite::Statement find(m.database, "SELECT id FROM run WHERE command = ? AND study_hash = ? AND settings = ?");
        find.bind(1, header.key.command);
        find.bind(2, header.key.study_hash);
        find.bind(3, header.key.settings);
        find.executeStep();
        const int id = find.getColumn(0).getInt();
        m.database.exec(fmt::format("UPDATE run SET used = (SELECT max(used) + 1 FROM run) WHERE id = {}", id));
        transaction.commit();
        return id;
    });
}

std::vector<RunHeader> Store::runs() const {
    const std::scoped_lock lock(mutex_);
    const auto& m = *implementation_;
    return m.guarded([&] {
        SQLite::Statement row(m.database, "SELECT id, command, study_hash, settings, version, header FROM run "
                                          "ORDER BY used DESC");
        std::vector<RunHeader> list;
        while (row.executeStep()) {
            RunHeader header;
            header.id = row.getColumn(0).getInt();
            header.key = {row.getColumn(1).getString(), row.getColumn(2).getString(), row.getColumn(3).getString()};
            header.version = row.getColumn(4).getString();
            fill_header(header, row.getColumn(5).getString());
            list.push_back(std::move(header));
        }
        if (list.empty()) {
            throw pave::Error({.file = m.file}, "the store holds no run", {}, "the folder of a run");
        }
        return list;
    });
}

void Store::put(int run, RunNumber number, const problem::Evaluation& e) {
    std::string warnings;
    for (const std::string& warning : e.warnings) {
        warnings += (warnings.empty() ? "" : "\n") + warning;
    }
    const std::scoped_lock lock(mutex_);
    if (e.over_time) {
        ++over_time_;
        return;
    }
    auto& m = *implementation_;
    m.guarded([&] {
        SQLite::Transaction transaction(m.database, SQLite::TransactionBehavior::IMMEDIATE);
        SQLite::Statement& s = *m.insert;
        s.reset();
        s.bind(1, run);
        s.bind(2, number.start);
        s.bind(3, number.number);
        s.bind(4, static_cast<int>(e.status));
        s.bind(5, e.reason);
        bind_doubles(s, 6, e.parameters.data(), e.parameters.size());
        bind_doubles(s, 7, e.responses.data(), e.responses.size());
        bind_doubles(s, 8, e.jacobian.data(), static_cast<std::size_t>(e.jacobian.size()));
        s.bind(9, warnings);
        if (e.converged()) {
            s.bind(10, e.misfit);
        } else {
            s.bind(10);
        }
        s.bind(11, e.in_place_of_reduced ? 1 : 0);
        s.exec();
        if (m.session) {
            count_evaluation();
        }
        transaction.commit();
    });
}

// The session stands in the store from its first evaluation on, so that ending the process leaves a true count.
void Store::count_evaluation() {
    auto& m = *implementation_;
    if (!m.count) {
        SQLite::Statement add(m.database,
                              "INSERT INTO session (version, libraries, arguments, directory, threads, began, seconds, "
                              "evaluations) VALUES (?, ?, ?, ?, ?, ?, 0, 0)");
        add.bind(1, m.session->version);
        add.bind(2, m.session->libraries);
        add.bind(3, nlohmann::json(m.session->arguments)
                        .dump(-1, ' ', false, nlohmann::json::error_handler_t::replace)); // names of files are bytes
        add.bind(4, m.session->directory);
        add.bind(5, m.session->threads);
        add.bind(6, m.session->began);
        add.exec();
        m.session_id = m.database.getLastInsertRowid();
        m.count = std::make_unique<SQLite::Statement>(
            m.database,
            fmt::format("UPDATE session SET seconds = ?, evaluations = evaluations + 1 WHERE id = {}", m.session_id));
    }
    m.inputs.write(m.database, m.session_id);
    m.count->reset();
    m.count->bind(1, std::chrono::duration<double>(std::chrono::steady_clock::now() - m.opened).count());
    m.count->exec();
}

void Store::keep_inputs(const std::string& study_hash, const std::vector<data::InputFile>& files) {
    const std::scoped_lock lock(mutex_);
    implementation_->inputs.add(study_hash, files);
}

std::vector<data::InputFile> Store::inputs(std::int64_t session) const {
    const std::scoped_lock lock(mutex_);
    return implementation_->guarded([&] { return inputs_of(implementation_->database, session); });
}

std::optional<std::string> Store::study_text(const std::string& study_hash) const {
    const std::scoped_lock lock(mutex_);
    return implementation_->guarded([&] { return study_text_of(implementation_->database, study_hash); });
}

std::vector<Session> Store::sessions() const {
    const std::scoped_lock lock(mutex_);
    const auto& m = *implementation_;
    return m.guarded([&] {
        std::vector<Session> list;
        SQLite::Statement row(m.database,
                              "SELECT version, libraries, arguments, directory, threads, began, seconds, evaluations, "
                              "id FROM session ORDER BY id");
        while (row.executeStep()) {
            list.push_back({.version = row.getColumn(0).getString(),
                            .libraries = row.getColumn(1).getString(),
                            .arguments = arguments_of(row.getColumn(2).getString()),
                            .directory = row.getColumn(3).getString(),
                            .threads = row.getColumn(4).getInt(),
                            .began = row.getColumn(5).getString(),
                            .seconds = row.getColumn(6).getDouble(),
                            .evaluations = row.getColumn(7).getInt64(),
                            .id = row.getColumn(8).getInt64()});
        }
        return list;
    });
}

std::map<RunNumber, problem::Evaluation> Store::get(int run, RunNumber first, RunNumber last) const {
    const std::scoped_lock lock(mutex_);
    const auto& m = *implementation_;
    return m.guarded([&] {
        const Shape shape = m.shape_of(run);
        std::map<RunNumber, problem::Evaluation> found;
        SQLite::Statement row(m.database, std::string(select_columns) +
                                              "run = ? AND (start, number) >= (?, ?) AND (start, number) <= (?, ?)");
        row.bind(1, run);
        row.bind(2, first.start);
        row.bind(3, first.number);
        row.bind(4, last.start);
        row.bind(5, last.number);
        while (row.executeStep()) {
            found.emplace(RunNumber{row.getColumn(0).getInt(), row.getColumn(1).getInt()},
                          evaluation_of(row, 2, shape));
        }
        return found;
    });
}

void Store::each(int run, const std::function<void(RunNumber, const problem::Evaluation&)>& visit) const {
    const std::scoped_lock lock(mutex_);
    const auto& m = *implementation_;
    m.guarded([&] {
        const Shape shape = m.shape_of(run);
        SQLite::Statement row(m.database, std::string(select_columns) + "run = ? ORDER BY start, number");
        row.bind(1, run);
        while (row.executeStep()) {
            visit({row.getColumn(0).getInt(), row.getColumn(1).getInt()}, evaluation_of(row, 2, shape));
        }
    });
}

std::size_t Store::over_time() const {
    const std::scoped_lock lock(mutex_);
    return over_time_;
}

void Store::put_result(int run, const std::string& json) {
    const std::scoped_lock lock(mutex_);
    auto& m = *implementation_;
    m.guarded([&] {
        SQLite::Statement s(m.database, "UPDATE run SET result = ? WHERE id = ?");
        s.bind(1, json);
        s.bind(2, run);
        s.exec();
    });
}

} // namespace explore::run
